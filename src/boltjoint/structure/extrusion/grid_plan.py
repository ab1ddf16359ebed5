"""Plan view of a grid of lines with holes: cells of bolts filled with rings around them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from boltjoint.structure.extrusion.bolt_plan import CellEdge, cell_rings
from boltjoint.structure.extrusion.cell import BoltRadii, CellDivisions
from boltjoint.structure.extrusion.plan import Labels, Plan, Points, closed, quads_of

if TYPE_CHECKING:
    from boltjoint.config.grid import Cell, Grid, Lines

Array = NDArray[np.float64]
#: distance of lines over that of the outermost ones, which is rounding
_APART = 1e-9
#: points in the plane (..., 2) of places along both directions of a grid
Map = Callable[[Array, Array], Points]


@dataclass(frozen=True, eq=False)
class BoltPlace:
    """A bolt in a grid: its axis [m], the directions and divisions of its cell, and its seat.

    ``seat`` (rings + 1, around): nodes from the edge of the hole to that of head or washer.
    """

    axis: Points
    edge: CellEdge
    divisions: CellDivisions
    seat: Labels


@dataclass(frozen=True, eq=False)
class GridPlan:
    """A grid with holes.

    ``plan`` [m]; ``label`` (lines, lines) of the nodes of the grid, -1 within cells, the first ones
    along the second direction repeated where it is closed; ``bolts`` in the order of the cells.
    """

    plan: Plan
    label: Labels
    bolts: tuple[BoltPlace, ...]


def places_of(lines: "Lines") -> Array:
    """Places of all lines, ascending, shape (elements + 1,)."""
    parts = [
        np.linspace(begin, end, elements + 1)[min(i, 1) :]
        for i, (begin, end, elements) in enumerate(lines.intervals)
    ]
    return np.concatenate(parts)


def grid_plan(
    grid: "Grid",
    axes: ArrayLike,
    radii: BoltRadii,
    rings: tuple[int, int, int, int],
    place: Map,
) -> GridPlan:
    """The plan of a grid, whose cells have holes.

    Parameters
    ----------
    grid
        Lines and cells.
    axes
        Axes of the bolts [m], shape (cells, 2).
    radii
        Circles of all bolts [m].
    rings
        Rings of elements in the shank, under the head, from the head to the edge of the cell, and
        of these under a washer beyond the head.
    place
        Where places along both directions of the grid lie [m].

    Raises
    ------
    ValueError
        If head or washer do not fit into a cell.
    """
    first, second = places_of(grid.first), places_of(grid.second)
    count = len(second) - int(grid.is_closed)
    point = place(*np.meshgrid(first, second[:count], indexing="ij"))
    spans = [_spans(grid, cell, first, second) for cell in grid.cells]
    is_node = np.ones((len(first), count), dtype=bool)
    is_quad = np.ones((len(first) - 1, len(second) - 1), dtype=bool)
    for (i, j), (k, m) in spans:
        is_node[i + 1 : j, k + 1 : m] = False
        is_quad[i:j, k:m] = False
    label = np.where(is_node, np.cumsum(is_node).reshape(is_node.shape) - 1, -1)
    if grid.is_closed:
        label = closed(label)
    points = [point[is_node]]
    quads = [quads_of(label)[is_quad.ravel()]]
    bolts, nodes = [], len(points[0])
    shank, under_head, to_edge, rim = rings
    for axis, ((i, j), (k, m)) in zip(np.asarray(axes), spans, strict=True):
        on_edge = np.concatenate([label[j, k:m], label[j:i:-1, m], label[i, m:k:-1], label[i:j, k]])
        line = points[0][on_edge] - axis
        edge = CellEdge.of_points(line)
        divisions = CellDivisions(m - k, j - i, shank, under_head, to_edge, rim)
        inside = cell_rings(line, edge, radii, divisions)[:-1]
        ring = nodes + np.arange(inside[..., 0].size).reshape(inside.shape[:2])
        ring = np.concatenate([ring, on_edge[None]])
        points.append((axis + inside).reshape(-1, 2))
        quads.append(quads_of(closed(ring)))
        nodes += len(points[-1])
        bolts.append(BoltPlace(axis, edge, divisions, ring[: under_head + rim + 1]))
    return GridPlan(Plan(np.concatenate(points), np.concatenate(quads)), label, tuple(bolts))


def _spans(
    grid: "Grid", cell: "Cell", first: Array, second: Array
) -> tuple[tuple[int, int], tuple[int, int]]:
    """First and last line of a cell along both directions."""
    starts = [
        np.searchsorted(places, span[0] - _APART * np.ptp(places))
        for places, span in ((first, cell.first), (second, cell.second))
    ]
    i, k = (int(start) for start in starts)
    along, across = grid.sides(cell)
    return (i, i + along), (k, k + across)
