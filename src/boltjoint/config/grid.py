"""Lines of a grid in which bolts have rectangular cells: where they lie, and what they count.

Lines go all through: those at the edges of cells and of bodies, and between them as many as
elements are to be long. A cell takes the lines that cross it as nodes on its edge.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from sys import float_info
from typing import NamedTuple

from boltjoint.config.described import COUNTLESS

Span = tuple[float, float]

#: decimals of mm, or of rad, to which places that differ by rounding are one
DIGITS = 10


class Interval(NamedTuple):
    """Elements of one length between two places."""

    begin: float
    end: float
    elements: int


class Lines(NamedTuple):
    """Lines across one direction of a grid, by the intervals between its breakpoints."""

    intervals: tuple[Interval, ...]

    @classmethod
    def between(
        cls, ends: Sequence[float], cells: Iterable[Span], coarse: float, fine: float
    ) -> "Lines":
        """Lines with breakpoints at ends of bodies and edges of cells.

        Parameters
        ----------
        ends
            Places that are lines, of which the outermost are the edges of the grid.
        cells
            Edges of all cells, in pairs.
        coarse, fine
            Length of elements outside cells, and of those in one.
        """
        spans = sorted({(round(low, DIGITS), round(high, DIGITS)) for low, high in cells})
        places = {round(end, DIGITS) for end in ends}
        places.update(edge for span in spans for edge in span)
        intervals = []
        for begin, end in pairwise(sorted(places)):
            is_fine = any(low <= begin and end <= high for low, high in spans)
            length = (end - begin) / max(fine if is_fine else coarse, float_info.min)
            # whole, but the quotient of what is allowed may be infinite
            intervals.append(Interval(begin, end, max(1, round(min(length, COUNTLESS)))))
        return cls(tuple(intervals))

    @property
    def elements(self) -> int:
        """Elements between all lines."""
        return sum(interval.elements for interval in self.intervals)

    def within(self, span: Span) -> int:
        """Elements between two breakpoints."""
        low, high = (round(edge, DIGITS) for edge in span)
        return sum(one.elements for one in self.intervals if low <= one.begin and one.end <= high)


class Cell(NamedTuple):
    """Edges of the cell of a bolt along both directions of the grid."""

    first: Span
    second: Span


class Grid(NamedTuple):
    """Lines of a grid along two directions, and cells in it, in the order of the bolts.

    Of a ring, ``is_closed``, the last line along the second direction is the first.
    """

    first: Lines
    second: Lines
    cells: tuple[Cell, ...]
    is_closed: bool = False

    def sides(self, cell: Cell) -> tuple[int, int]:
        """Elements along both sides of a cell."""
        return self.first.within(cell.first), self.second.within(cell.second)

    def size(self, rings: int) -> tuple[int, int]:
        """Nodes and quadrilaterals, with as many rings around holes in the cells."""
        along, across = self.first.elements, self.second.elements
        nodes = (along + 1) * (across + int(not self.is_closed))
        quads = along * across
        for one, other in map(self.sides, self.cells):
            around = 2 * (one + other)
            nodes += around * rings - (one - 1) * (other - 1)
            quads += around * rings - one * other
        return nodes, quads
