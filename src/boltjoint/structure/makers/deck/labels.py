"""Numbers and names of decks: nodes, elements and their sets, within instances of parts or not."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.deck.lines import Place

Indices = NDArray[np.int64]

#: of what lies in no instance
WHOLE = ""


class Numbering:
    """Numbers of nodes or elements, by instance, and the places that they have in arrays.

    Parameters
    ----------
    what
        ``node`` or ``element``, for messages.
    """

    def __init__(self, what: str) -> None:
        self.what = what
        self.label = np.zeros(0, np.int64)
        self.scope: list[tuple[str, int, int]] = []
        self._sorted: dict[str, tuple[Indices, Indices]] = {}

    def __len__(self) -> int:
        return len(self.label)

    def add(self, scope: str, label: Indices) -> Indices:
        """Places of new ones, whose numbers may have been there before."""
        first = len(self.label)
        self.label = np.concatenate([self.label, label])
        self.scope.append((scope, first, first + len(label)))
        self._sorted.clear()
        return np.arange(first, first + len(label))

    def of(self, scope: str) -> tuple[Indices, Indices]:
        """Numbers within an instance in rising order, and their places."""
        if scope not in self._sorted:
            of_scope = [np.arange(first, last) for name, first, last in self.scope if name == scope]
            place = np.concatenate([*of_scope, np.zeros(0, np.int64)])
            order = place[np.argsort(self.label[place], kind="stable")]
            self._sorted[scope] = self.label[order], order
        return self._sorted[scope]

    def places(self, scope: str, label: Indices, at: Place) -> Indices:
        """Places of numbers.

        Raises
        ------
        ValueError
            If there is no such number, or only in instances: ``at``, number, and what to write.
        """
        label = np.asarray(label, np.int64)
        labels, place = self.of(scope)
        index = np.searchsorted(labels, label)
        index[index == len(labels)] = 0
        missing = ~(labels[index] == label) if len(labels) else np.ones(len(label), bool)
        if missing.any():
            raise ValueError(f"{at}: {self._missing(scope, int(label[np.argmax(missing)]))}")
        return place[index]

    def name(self, place: int) -> str:
        """Number of one for messages, with its instance."""
        scope = next(name for name, first, last in self.scope if first <= place < last)
        return f"{self.what} {scope + '.' if scope else ''}{self.label[place]}"

    def twice(self) -> Iterable[tuple[int, int]]:
        """Places of pairs that have one number within one instance."""
        for scope in dict.fromkeys(name for name, _, _ in self.scope):
            label, place = self.of(scope)
            for again in np.flatnonzero(label[1:] == label[:-1]):
                yield int(place[again]), int(place[again + 1])

    def _missing(self, scope: str, label: int) -> str:
        within = [
            name
            for name in dict.fromkeys(name for name, _, _ in self.scope)
            if name and label in self.of(name)[0]
        ]
        if scope == WHOLE and within:
            several = f"instances {', '.join(within)} have one" if len(within) > 1 else ""
            one = several or f"instance {within[0]} has one"
            return f"{self.what} {label} is in no instance: {one}: write {within[0]}.{label}"
        of_scope = f" of instance {scope}" if scope else ""
        return f"{self.what} {label}{of_scope} is not defined"


@dataclass
class Members:
    """What data lines put into a set: numbers within an instance, or names of other sets."""

    scope: str
    place: Place
    labels: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    names: Sequence[str] = ()
    #: name of a set of elements whose nodes they are
    nodes_of: str = ""
    #: whether numbers that do not exist are left out, as those of a range
    is_range: bool = False


class Sets:
    """Sets by their names, of nodes or of elements, of pieces that later lines add to.

    Parameters
    ----------
    numbering
        Of what is in them.
    keyword
        NSET or ELSET, for messages.
    of_elements
        Nodes of the elements that members name; sets of elements have none.
    """

    def __init__(
        self,
        numbering: Numbering,
        keyword: str,
        of_elements: Callable[[Members], Indices] | None = None,
    ) -> None:
        self.numbering, self.keyword, self._of_elements = numbering, keyword, of_elements
        self.members: dict[str, list[Members]] = {}
        self.written: dict[str, str] = {}
        self._places: dict[str, Indices] = {}

    def add(self, scope: str, name: str, members: Members) -> None:
        """Add to a set, which there may be already."""
        key = scoped(scope, name)
        self.members.setdefault(key, []).append(members)
        self.written.setdefault(key, name if not scope else f"{scope}.{name}")

    def key(self, scope: str, name: str) -> str | None:
        """Name in capitals of a set as seen from an instance, None where there is none."""
        within = scoped(scope, name)
        return next((key for key in (within, name.upper()) if key in self.members), None)

    def places(self, scope: str, name: str, at: Place) -> Indices:
        """Places of the members of a set, each once, in the order in which they were added.

        Raises
        ------
        ValueError
            If there is no such set, or it names itself.
        """
        key = self.key(scope, name)
        if key is None:
            raise ValueError(f"{at}: there is no *{self.keyword} {name}")
        return self._resolved(key, at, ())

    def _resolved(self, key: str, at: Place, outer: tuple[str, ...]) -> Indices:
        if key in outer:
            raise ValueError(f"{at}: *{self.keyword} {self.written[key]} names itself")
        if key not in self._places:
            pieces = [np.zeros(0, np.int64)]
            for members in self.members[key]:
                pieces += self._pieces(key, members, outer)
            place = np.concatenate(pieces)
            first = np.unique(place, return_index=True)[1]
            self._places[key] = place[np.sort(first)]
        return self._places[key]

    def _pieces(self, key: str, members: Members, outer: tuple[str, ...]) -> list[Indices]:
        scope, at = members.scope, members.place
        label = members.labels
        if members.is_range:
            labels = self.numbering.of(scope)[0]
            label = labels[np.isin(labels, label)]
        pieces = [self.numbering.places(scope, label, at)] if len(label) else []
        if members.nodes_of and self._of_elements is not None:
            pieces.append(self._of_elements(members))
        for name in members.names:
            other = self.key(scope, name)
            instance, _, number = name.rpartition(".")
            if other is not None:
                pieces.append(self._resolved(other, at, (*outer, key)))
            elif number.isdigit() and instance:
                one = np.array([int(number)])
                pieces.append(self.numbering.places(instance.upper(), one, at))
            else:
                raise ValueError(
                    f"{at}: *{self.keyword} {self.written[key]}: there is no set {name}"
                )
        return pieces


def scoped(scope: str, name: str) -> str:
    """A name in capitals, within an instance where there is one."""
    return f"{scope}.{name}".upper() if scope else name.upper()
