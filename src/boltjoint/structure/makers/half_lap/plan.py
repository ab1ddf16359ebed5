"""Plan view of the lap: cells of bolts in a row, and columns of rectangles between them.

Every bolt sits in a rectangular cell; columns of rectangles fill the space between the cells.
Lengths are in metres, x along the bar, y across its width.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from boltjoint import checks
from boltjoint.structure.extrusion.bolt_plan import CellEdge, cell_rings, rectangle_edge
from boltjoint.structure.extrusion.cell import BoltRadii, CellDivisions, check_washer
from boltjoint.structure.extrusion.plan import (
    Labels,
    Plan,
    closed,
    glue,
    quads_of,
    rectangle_plan,
    stack_plans,
)


@dataclass(frozen=True)
class LapPlan:
    """Half of the lap seen from above.

    Attributes
    ----------
    plan
        Nodes and quadrilaterals.
    seat
        Nodes of the rings from the edge of the hole to the edge of the head, or of a wider washer,
        shape (bolts, rings + 1, around).
    first, last
        Nodes of the two ends of the lap, by ascending y, shape (across + 1,).
    """

    plan: Plan
    seat: Labels
    first: Labels
    last: Labels


def lap_plan(
    axes: ArrayLike,
    length: float,
    width: float,
    cell_length: float,
    radii: BoltRadii,
    divisions: CellDivisions,
    columns_between: int,
    columns_at_ends: int,
) -> LapPlan:
    """Half of the lap: a cell for each bolt, columns between the cells and at both ends.

    Parameters
    ----------
    axes
        x of the bolt axes, ascending, from the start of the lap [m].
    length, width
        Sides of the lap [m].
    cell_length
        Length of a bolt cell along x [m].
    radii, divisions
        Circles of a bolt, and elements of its cell.
    columns_between, columns_at_ends
        Elements along x between two cells, and between an outer cell and the end of the lap.

    Raises
    ------
    ValueError
        If head or washer do not fit into their cell, or the cells overlap or do not fit into the
        lap; or if a number is out of range.
    """
    check_washer(radii, divisions)
    axes = checks.array("axes", axes, ("bolts",))
    checks.instance("radii", radii, BoltRadii)
    checks.instance("divisions", divisions, CellDivisions)
    for name, value in (("length", length), ("width", width), ("cell_length", cell_length)):
        checks.number(name, value, above=0)
    for name, value in (("columns_between", columns_between), ("columns_at_ends", columns_at_ends)):
        checks.whole(name, value, at_least=1)
    edges = _edges_of_cells(axes, length, width, cell_length, radii)

    y = np.linspace(-width / 2, width / 2, divisions.across + 1)
    cell = _cell_plan(cell_length, width, radii, divisions)
    rings = np.arange(len(cell.point)).reshape(-1, divisions.around)
    edge, across, along = rings[-1], divisions.across, divisions.along
    cell_last = edge[: across + 1]
    cell_first = edge[across + along : 2 * across + along + 1][::-1]

    columns = [columns_at_ends, *[columns_between] * (len(axes) - 1), columns_at_ends]
    strips = [
        rectangle_plan(np.linspace(low, high, n + 1), y)
        for low, high, n in zip(edges[::2], edges[1::2], columns, strict=True)
    ]
    cells = [cell.moved(axis) for axis in axes]
    point, quad, offset = stack_plans([*cells, *strips])
    cell_offset, strip_offset = offset[: len(cells)], offset[len(cells) :]

    # a strip takes its first nodes from the cell before it and its last ones from the cell after it
    line = np.arange(across + 1)
    kept = [begin + cell_last for begin in cell_offset]
    kept += [begin + cell_first for begin in cell_offset]
    given_up = [begin + line for begin in strip_offset[1:]]
    given_up += [
        begin + n * (across + 1) + line
        for begin, n in zip(strip_offset[:-1], columns[:-1], strict=True)
    ]
    label, remaining = glue(point, np.concatenate(kept), np.concatenate(given_up))
    in_seat = rings[: divisions.rings_under_head + divisions.rings_head_to_washer + 1]
    return LapPlan(
        plan=Plan(point[remaining], label[quad]),
        seat=label[np.stack([o + in_seat for o in cell_offset])],
        first=label[strip_offset[0] + line],
        last=label[strip_offset[-1] + columns[-1] * (across + 1) + line],
    )


def _edges_of_cells(
    axes: NDArray[np.float64], length: float, width: float, cell_length: float, radii: BoltRadii
) -> NDArray[np.float64]:
    """Where the cells of bolts begin and end along the lap, and the lap itself [m]."""
    if 2 * radii.seat >= min(cell_length, width):
        what = "head" if radii.washer is None else "washer"
        raise ValueError(
            f"a {what} of {2e3 * radii.seat:g} mm does not fit into a bolt cell of "
            f"{1e3 * cell_length:g} mm x {1e3 * width:g} mm"
        )
    starts = np.asarray(axes) - cell_length / 2
    edges = np.concatenate([[0.0], np.stack([starts, starts + cell_length], -1).ravel(), [length]])
    if np.any(np.diff(edges) <= 1e-9):
        raise ValueError(
            f"bolt cells of {1e3 * cell_length:g} mm at x = "
            f"{', '.join(f'{1e3 * axis:g}' for axis in axes)} mm overlap, touch or leave the lap "
            f"of {1e3 * length:g} mm"
        )
    return edges


def _cell_plan(length: float, width: float, radii: BoltRadii, divisions: CellDivisions) -> Plan:
    line = rectangle_edge(length, width, divisions.along, divisions.across)
    rings = cell_rings(line, CellEdge.of_rectangle(divisions), radii, divisions)
    label = np.arange(rings[..., 0].size).reshape(rings.shape[:2])
    return Plan(rings.reshape(-1, 2), quads_of(closed(label)))
