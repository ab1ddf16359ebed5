"""Numerical options: numbers that can move a result, each with the reason of its default.

Their docstrings say what each number does, and where it comes from; the page ``docs/options.md`` is
made from them. Results store those that they were computed with.
"""

import inspect
import json
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from operator import methodcaller

from boltjoint import checks

#: highest harmonics with which a peak is sought until further ones change nothing: descriptions of
#: keys in ``config`` and ``docs/theory.md`` tell them
CONVERGING = (3, 9, 17, 33)


@dataclass(frozen=True)
class Options:
    """Base of frozen dataclasses of options, positive numbers unless a class says otherwise."""

    def __post_init__(self) -> None:
        """Refuse numbers that are not positive, or of another kind than their defaults."""
        for option in fields(self):
            if isinstance(option.default, int):
                checks.whole(option.name, getattr(self, option.name), at_least=1)
            elif isinstance(option.default, float):
                checks.number(option.name, getattr(self, option.name), above=0)

    def stored(self) -> str:
        """All options as JSON, for the attributes of a result."""
        return json.dumps(asdict(self), default=methodcaller("item"))

    @classmethod
    def descriptions(cls) -> Iterator[tuple[list[str], str]]:
        """Options and their description, one after another as in the docstring."""
        docstring = inspect.getdoc(cls) or ""
        section = re.search(
            r"^Parameters\n-+\n(.*?)(?:\n\n\w+\n-+\n|\Z)", docstring, re.DOTALL | re.MULTILINE
        )
        described = section[1] if section else ""
        for names, text in re.findall(r"^(\w[\w, ]*)\n((?:    .*\n?)+)", described, re.MULTILINE):
            yield names.split(", "), " ".join(text.split())
