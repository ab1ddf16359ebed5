"""Plan views of meshes: nodes and quadrilaterals in the plane, joined by labels.

Lengths are in metres.

References
----------
W. J. Gordon, C. A. Hall: Transfinite element methods: blending-function interpolation over
arbitrary curved element domains. Numerische Mathematik 21 (1973) 109-129.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

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

    def moved(self, x: float, y: float = 0.0) -> "Plan":
        """The same plan further along x and y [m]."""
        x, y = checks.number("x", x), checks.number("y", y)
        return Plan(self.point + np.array([x, y]), self.quad)


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
    return Plan(point, quads_of(np.arange(len(point)).reshape(len(x), len(y))))


def tributary_area(plan: Plan) -> Points:
    """Area of each node [m2], shape (points,): its shape function integrated over the plan.

    A uniform pressure times these areas is its consistent nodal force.

    Raises
    ------
    ValueError
        If ``plan`` is not a ``Plan``.
    """
    checks.instance("plan", plan, Plan)
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    area = np.zeros(len(plan.point))
    for gauss in corner / np.sqrt(3):
        factor = 1 + corner * gauss
        slope = corner * factor[:, ::-1] / 4
        jacobian = np.linalg.det(np.einsum("qci,cj->qij", plan.point[plan.quad], slope))
        share = np.outer(jacobian, factor.prod(axis=1) / 4)
        area += np.bincount(plan.quad.ravel(), share.ravel(), minlength=len(area))
    return area


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


def filled(lattice: Points) -> Points:
    """Inner points of a lattice from those on its edges (transfinite interpolation)."""
    u = np.linspace(0, 1, lattice.shape[0])[:, None, None]
    v = np.linspace(0, 1, lattice.shape[1])[None, :, None]
    west, east, south, north = lattice[:1], lattice[-1:], lattice[:, :1], lattice[:, -1:]
    sides = (1 - u) * west + u * east + (1 - v) * south + v * north
    corners = (1 - u) * ((1 - v) * west[:, :1] + v * west[:, -1:]) + u * (
        (1 - v) * east[:, :1] + v * east[:, -1:]
    )
    return sides - corners


def rings_between(inner: Points, outer: Points, rings: int) -> Points:
    """Rings of points from one closed line to another, shape (rings + 1, around, 2)."""
    share = np.linspace(0, 1, rings + 1)[:, None, None]
    return (1 - share) * inner + share * outer


def closed(lattice: Labels) -> Labels:
    return np.concatenate([lattice, lattice[:, :1]], axis=1)


def quads_of(lattice: Labels) -> Labels:
    """Quadrilaterals of a lattice of labels whose second index turns left from its first."""
    corners = [lattice[:-1, :-1], lattice[1:, :-1], lattice[1:, 1:], lattice[:-1, 1:]]
    return np.stack(corners, axis=-1).reshape(-1, 4)
