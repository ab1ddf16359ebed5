"""What installed packages add to this one by entry points: makers, friction laws, displays."""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import ModuleType
from typing import TypeVar

Thing = TypeVar("Thing")


@cache  # all installed packages are asked
def entries(group: str) -> dict[str, EntryPoint]:
    """Entry points of a group by their names; each names a module."""
    return {point.name: point for point in entry_points(group=group)}


class WithOtherPackages(Mapping[str, Thing]):
    """Things of this package by their names, and after them those of other packages.

    Other packages are asked only for a name that is none of this package, or for all names.

    Parameters
    ----------
    own
        Things of this package.
    group
        Entry points by which other packages name modules.
    of_module
        The thing in such a module.
    """

    def __init__(
        self, own: Mapping[str, Thing], group: str, of_module: Callable[[ModuleType], Thing]
    ) -> None:
        self.own, self.group, self._of_module = own, group, of_module
        self._loaded: dict[str, Thing] = {}

    def __getitem__(self, name: str) -> Thing:
        """The thing of this name; a ``KeyError`` if there is none."""
        if name in self.own:
            return self.own[name]
        if name not in self._loaded:
            self._loaded[name] = self._of_module(entries(self.group)[name].load())
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        """The names, those of this package first."""
        yield from self.own
        yield from (name for name in entries(self.group) if name not in self.own)

    def __len__(self) -> int:
        """How many there are."""
        return len(tuple(iter(self)))
