"""Radii and divisions of the cell of a bolt."""

from dataclasses import dataclass
from itertools import pairwise

from boltjoint import checks


@dataclass(frozen=True)
class CellDivisions:
    """Divisions of a bolt cell: elements along its sides, rings between its circles.

    ``rings_head_to_washer`` of ``rings_head_to_edge`` lie under a washer that is wider than the
    head.

    Raises
    ------
    ValueError
        If one of them is not a positive whole number, or no ring lies beyond the washer.
    """

    across: int
    along: int
    rings_in_shank: int
    rings_under_head: int
    rings_head_to_edge: int
    rings_head_to_washer: int = 0

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name, value in vars(self).items():
            checks.whole(name, value, at_least=int(name != "rings_head_to_washer"))
        within = self.rings_head_to_edge
        checks.whole("rings_head_to_washer", self.rings_head_to_washer, below=within)

    @property
    def around(self) -> int:
        """Elements around the bolt."""
        return 2 * (self.across + self.along)


@dataclass(frozen=True)
class BoltRadii:
    """Radii of shank, hole and head, and of washers that have others [m].

    ``washer_hole`` is narrower than the hole in the bars, ``washer`` wider than the head; None
    where they are the same, or there are no washers.

    Raises
    ------
    ValueError
        If one of them is not positive, or they do not increase from the inside.
    """

    shank: float
    hole: float
    head: float
    washer_hole: float | None = None
    washer: float | None = None

    def __post_init__(self) -> None:
        """Check that the radii increase."""
        inside_first = {
            name: radius
            for name in ("shank", "washer_hole", "hole", "head", "washer")
            if (radius := getattr(self, name)) is not None
        }
        for name, value in inside_first.items():
            checks.number(name, value, above=0)
        radii = list(inside_first.values())
        if not all(inner < outer for inner, outer in pairwise(radii)):
            *others, last = inside_first
            *smaller, largest = (f"{radius:g}" for radius in radii)
            raise ValueError(
                f"{', '.join(others)} and {last} have radii of {', '.join(smaller)} and {largest} "
                "m: they must increase in this order"
            )

    @property
    def seat(self) -> float:
        """Radius of what is tied to the bars: of the washer, or of the head."""
        return self.head if self.washer is None else self.washer


def check_washer(radii: BoltRadii, divisions: CellDivisions) -> None:
    """Refuse a wide washer without rings beyond the head, and such rings without a wide washer.

    Raises
    ------
    ValueError
        If one is there without the other.
    """
    checks.instance("radii", radii, BoltRadii)
    checks.instance("divisions", divisions, CellDivisions)
    rings = divisions.rings_head_to_washer
    if (radii.washer is None) != (rings == 0):
        needed = "0 without a washer wider" if radii.washer is None else "positive with one wider"
        raise ValueError(f"rings_head_to_washer is {rings}: it must be {needed} than the head")
