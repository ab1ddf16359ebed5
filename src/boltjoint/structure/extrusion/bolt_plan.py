"""Plan views of a bolt and of the cell of quadrilaterals around it.

Rings of quadrilaterals lead from the edge of the hole over the edge of the head to the edge of the
cell (an O-grid). Lengths are in metres.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from boltjoint import checks
from boltjoint.structure.extrusion.cell import BoltRadii, CellDivisions, check_washer
from boltjoint.structure.extrusion.plan import (
    Labels,
    Plan,
    Points,
    closed,
    filled,
    quads_of,
    rings_between,
)

#: mean distance of the edge of the unit square from its middle
_SQUARE = 0.56


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
        Number of rings inside the edge of the hole in the plates, which the others lie on.
    """

    head: Plan
    shank: Plan
    under_head: Labels
    washer: Plan
    rings_of_washer: Labels
    over_hole: int

    def moved(self, x: float, y: float = 0.0) -> "BoltPlan":
        """The same plan with its axis at x, y [m]."""
        parts = {name: getattr(self, name).moved(x, y) for name in ("head", "shank", "washer")}
        return replace(self, **parts)


@dataclass(frozen=True, eq=False)
class CellEdge:
    """Nodes around a bolt, counter-clockwise about its axis, from the corner at +x, -y.

    ``circle`` (around, 2) of a polygon with the area of the unit circle; ``square`` (around, 2), in
    the shape of the edge of the cell, of about unit size.
    """

    circle: Points
    square: Points

    @classmethod
    def of_rectangle(cls, divisions: CellDivisions) -> "CellEdge":
        """Nodes at equal angles and distances."""
        circle = _circle_points(divisions.across, divisions.around)
        return cls(circle, rectangle_edge(1.0, 1.0, divisions.along, divisions.across))

    @classmethod
    def of_points(cls, point: Points) -> "CellEdge":
        """Nodes on straight lines from the axis to those on the edge of a cell.

        Parameters
        ----------
        point
            Those on the edge, from the axis [m], shape (around, 2).

        Raises
        ------
        ValueError
            If the axis does not see the whole edge from inside.
        """
        point = checks.array("point", point, ("around", 2))
        distance = np.linalg.norm(point, axis=1)
        one = point / distance[:, None]
        following = np.roll(one, -1, axis=0)
        sine = one[:, 0] * following[:, 1] - one[:, 1] * following[:, 0]
        if not sine.min() > 0:
            raise ValueError("point: the axis does not see the whole edge of the cell from inside")
        return cls(np.sqrt(2 * np.pi / sine.sum()) * one, _SQUARE / distance.mean() * point)


def bolt_plan(radii: BoltRadii, divisions: CellDivisions, edge: CellEdge | None = None) -> BoltPlan:
    """Head, shank and washer: a core of rectangles inside rings, which meet those of the cell.

    Parameters
    ----------
    radii, divisions
        Circles of the bolt, and elements of its cell.
    edge
        Directions of the nodes around it; by default those of a rectangular cell.

    Raises
    ------
    ValueError
        If there is a washer without rings, or rings without a washer.
    """
    check_washer(radii, divisions)
    around = divisions.around
    edge = CellEdge.of_rectangle(divisions) if edge is None else edge
    core, boundary = _core_plan(radii.shank, divisions, edge)
    circle = edge.circle
    shank_rings = rings_between(
        core.point[boundary], radii.shank * circle, divisions.rings_in_shank
    )
    head_rings = rings_between(radii.hole * circle, radii.head * circle, divisions.rings_under_head)
    if radii.washer_hole is not None:
        head_rings = np.concatenate([radii.washer_hole * circle[None], head_rings])
    # the ring from the shank outwards spans the clearance and exists in head and nut only
    outer = np.concatenate([shank_rings[1:], head_rings]).reshape(-1, 2)
    new = len(core.point) + np.arange(len(outer)).reshape(-1, around)
    lattice = np.concatenate([boundary[None], new])
    point = np.concatenate([core.point, outer])

    rim = rings_between(head_rings[-1], radii.seat * circle, divisions.rings_head_to_washer)[1:]
    washer = np.concatenate([head_rings, rim])
    rings_of_washer = np.arange(washer[..., 0].size).reshape(-1, around)
    in_shank = len(core.point) + divisions.rings_in_shank * around
    quads = np.concatenate([core.quad, quads_of(closed(lattice))])
    return BoltPlan(
        head=Plan(point, quads),
        shank=Plan(point[:in_shank], quads[quads.max(axis=1) < in_shank]),
        under_head=new[divisions.rings_in_shank :],
        washer=Plan(washer.reshape(-1, 2), quads_of(closed(rings_of_washer))),
        rings_of_washer=rings_of_washer,
        over_hole=int(radii.washer_hole is not None),
    )


def cell_rings(line: Points, edge: CellEdge, radii: BoltRadii, divisions: CellDivisions) -> Points:
    """Nodes of the rings of a cell, from the edge of the hole outwards.

    Parameters
    ----------
    line
        Nodes on the edge of the cell, from the axis of its bolt [m], shape (around, 2).
    edge
        Directions of the nodes around the bolt.
    radii, divisions
        Circles of the bolt, and elements of its cell.

    Returns
    -------
    ndarray
        Shape (rings + 1, around, 2) [m].
    """
    lines = [radii.hole * edge.circle, radii.head * edge.circle, radii.seat * edge.circle, line]
    in_washer = divisions.rings_head_to_washer
    rings = [divisions.rings_under_head, in_washer, divisions.rings_head_to_edge - in_washer]
    parts = [rings_between(*ends, n) for ends, n in zip(pairwise(lines), rings, strict=True)]
    return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])


def _core_plan(
    shank_radius: float, divisions: CellDivisions, edge: CellEdge
) -> tuple[Plan, Labels]:
    """Rectangles in the middle of the shank, and the labels around them, counter-clockwise."""
    across, along = divisions.across, divisions.along
    # halfway between a square and a circle, so that no corner of the core is flat or pointed
    boundary = 0.4 * shank_radius * (edge.square + edge.circle)
    label = np.arange((along + 1) * (across + 1)).reshape(along + 1, across + 1)
    around = np.concatenate([label[-1, :], label[-2::-1, -1], label[0, -2::-1], label[1:-1, 0]])
    point = np.zeros((label.size, 2))
    point[around] = boundary
    lattice = filled(point.reshape(along + 1, across + 1, 2))
    return Plan(lattice.reshape(-1, 2), quads_of(label)), around


def _circle_points(across: int, around: int) -> Points:
    """Points of a polygon with the area of the unit circle, from the corner at +x, -y on."""
    angle = 2 * np.pi * (np.arange(around) - across / 2) / around
    radius = np.sqrt(2 * np.pi / (around * np.sin(2 * np.pi / around)))
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def rectangle_edge(length: float, width: float, along: int, across: int) -> Points:
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
