"""Plan views of the mesh: quadrilaterals of the lap, of a free bar and of a bolt.

Every bolt sits in a rectangular cell filled with rings of quadrilaterals, from the edge of the hole
over the edge of the head to the edge of the cell (an O-grid); columns of rectangles fill the
space between the cells. Lengths are in metres, x along the bar, y across its width.

References
----------
W. J. Gordon, C. A. Hall: Transfinite element methods: blending-function interpolation over
arbitrary curved element domains. Numerische Mathematik 21 (1973) 109-129.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from boltjoint import checks
from boltjoint.structure.makers.half_lap.cell import BoltRadii, CellDivisions, check_washer

Points = NDArray[np.float64]
Labels = NDArray[np.int64]


@dataclass(frozen=True)
class Plan:
    """Nodes and quadrilaterals in the plane.

    ``point`` (points, 2) [m]; ``quad`` (quads, 4) counter-clockwise.

    Raises
    ------
    ValueError
        If they are not of these shapes, a point is not finite, or a quadrilateral has a node that
        does not exist.
    """

    point: Points
    quad: Labels

    def __post_init__(self) -> None:
        """Check the shapes."""
        point = checks.array("point", self.point, ("points", 2))
        quad = checks.indices("quad", self.quad, ("quads", 4), count=len(point))
        object.__setattr__(self, "point", point)
        object.__setattr__(self, "quad", quad)

    def moved(self, x: float) -> "Plan":
        """The same plan further along the bar [m]."""
        x = checks.number("x", x)
        return Plan(self.point + np.array([x, 0.0]), self.quad)


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


@dataclass(frozen=True)
class BoltPlan:
    """Head of a bolt and its washer seen from above, their axis at the origin.

    Attributes
    ----------
    head
        Nodes and quadrilaterals of the head.
    shank
        Those of the shank; its nodes are the first ones of the head.
    under_head
        Nodes of the head's rings around the shank, from the inside, shape (rings + 1, around).
    washer
        Nodes and quadrilaterals of the washer; its first rings are those of the head.
    rings_of_washer
        Nodes of the washer's rings, from the inside, shape (rings + 1, around).
    over_hole
        Number of rings inside the edge of the hole in the bars, which the others lie on.
    """

    head: Plan
    shank: Plan
    under_head: Labels
    washer: Plan
    rings_of_washer: Labels
    over_hole: int

    def moved(self, x: float) -> "BoltPlan":
        """The same plan with its axis further along the bar [m]."""
        parts = {name: getattr(self, name).moved(x) for name in ("head", "shank", "washer")}
        return replace(self, **parts)


def rectangle_plan(x: NDArray[np.float64], y: NDArray[np.float64]) -> Plan:
    """Rectangles between the lines x and y; the nodes of one x stand together, by ascending y.

    Parameters
    ----------
    x, y
        Ascending, shapes (columns + 1,) and (rows + 1,) [m].

    Raises
    ------
    ValueError
        If there are not two or more of each that ascend.
    """
    x, y = checks.ascending("x", x), checks.ascending("y", y)
    point = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return Plan(point, _quads(np.arange(len(point)).reshape(len(x), len(y))))


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


def bolt_plan(radii: BoltRadii, divisions: CellDivisions) -> BoltPlan:
    """Head, shank and washer: a core of rectangles inside rings, which meet those of the cell.

    Raises
    ------
    ValueError
        If there is a washer without rings, or rings without a washer.
    """
    check_washer(radii, divisions)
    around = divisions.around
    core, boundary = _core_plan(radii.shank, divisions)
    circle = _circle(divisions.across, around)
    shank_rings = _between(core.point[boundary], radii.shank * circle, divisions.rings_in_shank)
    head_rings = _between(radii.hole * circle, radii.head * circle, divisions.rings_under_head)
    if radii.washer_hole is not None:
        head_rings = np.concatenate([radii.washer_hole * circle[None], head_rings])
    # the ring from the shank outwards spans the clearance and exists in head and nut only
    outer = np.concatenate([shank_rings[1:], head_rings]).reshape(-1, 2)
    new = len(core.point) + np.arange(len(outer)).reshape(-1, around)
    lattice = np.concatenate([boundary[None], new])
    point = np.concatenate([core.point, outer])

    rim = _between(head_rings[-1], radii.seat * circle, divisions.rings_head_to_washer)[1:]
    washer = np.concatenate([head_rings, rim])
    rings_of_washer = np.arange(washer[..., 0].size).reshape(-1, around)
    in_shank = len(core.point) + divisions.rings_in_shank * around
    quads = np.concatenate([core.quad, _quads(_closed(lattice))])
    return BoltPlan(
        head=Plan(point, quads),
        shank=Plan(point[:in_shank], quads[quads.max(axis=1) < in_shank]),
        under_head=new[divisions.rings_in_shank :],
        washer=Plan(washer.reshape(-1, 2), _quads(_closed(rings_of_washer))),
        rings_of_washer=rings_of_washer,
        over_hole=int(radii.washer_hole is not None),
    )


def stack_plans(plans: Sequence[Plan]) -> tuple[Points, Labels, Labels]:
    """Points and quadrilaterals of several plans together, and the first label of each plan."""
    offset = np.concatenate([[0], np.cumsum([len(plan.point) for plan in plans])[:-1]])
    quad = np.concatenate([plan.quad + o for plan, o in zip(plans, offset, strict=True)])
    return np.concatenate([plan.point for plan in plans]), quad, offset


def glue(point: Points, kept: Labels, given_up: Labels) -> tuple[Labels, Labels]:
    """Make two sets of nodes one: the new label of every node, and which nodes remain.

    Nodes are joined by label, never by distance, so that the two faces of a contact stay apart.

    Raises
    ------
    ValueError
        If nodes that are to be joined do not exist, or do not lie on one another.
    """
    point = checks.array("point", point, ("nodes", "axes"))
    kept = checks.indices("kept", kept, ("joined",), count=len(point))
    given_up = checks.indices("given_up", given_up, ("joined",), count=len(point))
    if kept.shape != given_up.shape or not np.allclose(point[kept], point[given_up], atol=1e-9):
        raise ValueError("nodes that are to be joined do not lie on one another")
    remains = np.ones(len(point), dtype=bool)
    remains[given_up] = False
    label = np.cumsum(remains) - 1
    label[given_up] = label[kept]
    return label, np.flatnonzero(remains)


def _cell_plan(length: float, width: float, radii: BoltRadii, divisions: CellDivisions) -> Plan:
    circle = _circle(divisions.across, divisions.around)
    edge = _rectangle_edge(length, width, divisions.along, divisions.across)
    lines = [radii.hole * circle, radii.head * circle, radii.seat * circle, edge]
    in_washer = divisions.rings_head_to_washer
    rings = [divisions.rings_under_head, in_washer, divisions.rings_head_to_edge - in_washer]
    parts = [_between(*ends, n) for ends, n in zip(pairwise(lines), rings, strict=True)]
    point = np.concatenate([parts[0], *(part[1:] for part in parts[1:])]).reshape(-1, 2)
    return Plan(point, _quads(_closed(np.arange(len(point)).reshape(-1, divisions.around))))


def _core_plan(shank_radius: float, divisions: CellDivisions) -> tuple[Plan, Labels]:
    """Rectangles in the middle of the shank, and the labels around them as ``_circle`` counts."""
    across, along = divisions.across, divisions.along
    # halfway between a square and a circle, so that no corner of the core is flat or pointed
    square = _rectangle_edge(1.0, 1.0, along, across)
    boundary = 0.4 * shank_radius * (square + _circle(across, divisions.around))
    label = np.arange((along + 1) * (across + 1)).reshape(along + 1, across + 1)
    around = np.concatenate([label[-1, :], label[-2::-1, -1], label[0, -2::-1], label[1:-1, 0]])
    point = np.zeros((label.size, 2))
    point[around] = boundary
    lattice = _fill(point.reshape(along + 1, across + 1, 2))
    return Plan(lattice.reshape(-1, 2), _quads(label)), around


def _fill(lattice: Points) -> Points:
    """Inner points of a lattice from those on its edges (transfinite interpolation)."""
    u = np.linspace(0, 1, lattice.shape[0])[:, None, None]
    v = np.linspace(0, 1, lattice.shape[1])[None, :, None]
    west, east, south, north = lattice[:1], lattice[-1:], lattice[:, :1], lattice[:, -1:]
    sides = (1 - u) * west + u * east + (1 - v) * south + v * north
    corners = (1 - u) * ((1 - v) * west[:, :1] + v * west[:, -1:]) + u * (
        (1 - v) * east[:, :1] + v * east[:, -1:]
    )
    return sides - corners


def _circle(across: int, around: int) -> Points:
    """Points of a polygon with the area of the unit circle, from the corner at +x, -y on."""
    angle = 2 * np.pi * (np.arange(around) - across / 2) / around
    radius = np.sqrt(2 * np.pi / (around * np.sin(2 * np.pi / around)))
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _rectangle_edge(length: float, width: float, along: int, across: int) -> Points:
    """Points on the edge of a rectangle, counter-clockwise from its corner at +x, -y."""
    x, y = np.linspace(-0.5, 0.5, along + 1), np.linspace(-0.5, 0.5, across + 1)
    low_x, low_y = np.full(along, -0.5), np.full(across, -0.5)
    edge = [
        np.stack([-low_y, y[:-1]], axis=-1),
        np.stack([x[:0:-1], -low_x], axis=-1),
        np.stack([low_y, y[:0:-1]], axis=-1),
        np.stack([x[:-1], low_x], axis=-1),
    ]
    return np.concatenate(edge) * [length, width]


def _between(inner: Points, outer: Points, rings: int) -> Points:
    """Rings of points from one closed line to another, shape (rings + 1, around, 2)."""
    share = np.linspace(0, 1, rings + 1)[:, None, None]
    return (1 - share) * inner + share * outer


def _closed(lattice: Labels) -> Labels:
    return np.concatenate([lattice, lattice[:, :1]], axis=1)


def _quads(lattice: Labels) -> Labels:
    """Quadrilaterals of a lattice of labels whose second index turns left from its first."""
    corners = [lattice[:-1, :-1], lattice[1:, :-1], lattice[1:, 1:], lattice[:-1, 1:]]
    return np.stack(corners, axis=-1).reshape(-1, 4)
