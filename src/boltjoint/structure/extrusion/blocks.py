"""Plans extruded along z to hexahedra, and joined node by node."""

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.structure.extrusion.plan import Labels, Plan, glue

Array = NDArray[np.float64]


def extrude(plan: Plan, levels: Array) -> tuple[NDArray, NDArray]:
    """Extrude a plan along z.

    Parameters
    ----------
    plan
        Nodes and quadrilaterals.
    levels
        Ascending z of the nodes [m].

    Returns
    -------
    tuple
        Nodes (levels * points, 3) [m], level by level, and hexahedra (hexahedra, 8) in the order
        of VTK.

    Raises
    ------
    ValueError
        If ``plan`` is not a ``Plan``, or there are not two or more ascending levels.
    """
    checks.instance("plan", plan, Plan)
    levels = checks.ascending("levels", levels)
    n = len(plan.point)
    point = np.column_stack([np.tile(plan.point, (len(levels), 1)), np.repeat(levels, n)])
    below = n * np.arange(len(levels) - 1)[:, None, None] + plan.quad
    return point, np.concatenate([below, below + n], axis=-1).reshape(-1, 8)


class Blocks:
    """Extruded plans, and the pairs of their nodes that are joined."""

    def __init__(self) -> None:
        self._point: list[Array] = []
        self._hexahedron: list[Labels] = []
        self._part: list[Labels] = []
        self._kept: list[Labels] = []
        self._given_up: list[Labels] = []
        self._nodes = 0

    def add(self, part: int, plan: Plan, levels: Array) -> Labels:
        """Extrude a plan; the labels of its nodes, shape (levels, points)."""
        point, hexahedron = extrude(plan, levels)
        label = self._nodes + np.arange(len(point)).reshape(len(levels), -1)
        self._point.append(point)
        self._hexahedron.append(self._nodes + hexahedron)
        self._part.append(np.full(len(hexahedron), part))
        self._nodes += len(point)
        return label

    def join(self, kept: Labels, given_up: Labels) -> None:
        """Make two sets of nodes one, by their labels."""
        self._kept.append(kept.ravel())
        self._given_up.append(given_up.ravel())

    def joined(self) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """Coordinates, hexahedra, parts, and the final label of every label given so far."""
        point = np.concatenate(self._point)
        label, remaining = glue(point, np.concatenate(self._kept), np.concatenate(self._given_up))
        hexahedron = label[np.concatenate(self._hexahedron)]
        return point[remaining], hexahedron, np.concatenate(self._part), label
