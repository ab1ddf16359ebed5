"""Unknowns of a deck: displacements of nodes, rotations of some, shortenings of bolts."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.deck.content import Axes, Deck, Reference
from boltjoint.structure.makers.deck.labels import Indices

Array = NDArray[np.float64]

AXES = 3


@dataclass
class Unknowns:
    """Columns of all constraints, stiffness and mass.

    First the displacements along x, y, z of all nodes, copies at sections last; then the rotations
    of nodes that have some; then the shortening of each section.

    Attributes
    ----------
    deck
        What was read.
    nodes
        Number of nodes with the copies.
    turning
        Nodes that have rotations.
    sections
        Nodes whose first displacement is the shortening of a section, in their order.
    """

    deck: Deck
    nodes: int
    turning: Indices
    sections: list[int] = field(default_factory=list)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return AXES * (self.nodes + len(self.turning)) + len(self.sections)

    def translations(self, node: Indices) -> Indices:
        """Unknowns of nodes along x, y, z, shape (nodes, 3)."""
        return AXES * np.asarray(node)[..., None] + np.arange(AXES)

    def rotations(self, node: int) -> Indices | None:
        """Unknowns of the rotation of a node, None where it has none."""
        place = np.searchsorted(self.turning, node)
        if place == len(self.turning) or self.turning[place] != node:
            return None
        return AXES * (self.nodes + place) + np.arange(AXES)

    def shortening(self, section: int) -> int:
        """The unknown of a section."""
        return AXES * (self.nodes + len(self.turning)) + section

    def terms(self, reference: Reference, node: int, dof: int) -> tuple[Indices, Array]:
        """Unknowns and factors of a displacement, 1 to 3, or rotation, 4 to 6, of a node.

        Raises
        ------
        ValueError
            If the node has no such displacement.
        """
        if node in self.sections:
            if dof != 1:
                raise ValueError(
                    f"{reference.place}: {self.deck.nodes.name(node)} is that of a pre-tension "
                    "section: it has displacement 1 alone"
                )
            return np.array([self.shortening(self.sections.index(node))]), np.ones(1)
        columns = self.translations(np.array(node))
        if dof > AXES:
            columns = self.rotations(node)
            if columns is None:
                raise ValueError(
                    f"{reference.place}: {self.deck.nodes.name(node)} has no rotation {dof}: no "
                    "coupling, rigid body or beam turns it"
                )
        direction = self.directions(node)[(dof - 1) % AXES]
        acting = np.flatnonzero(direction)
        return columns[acting], direction[acting]

    def directions(self, node: int) -> Array:
        """Directions in which displacements of a node are given, as rows."""
        axes = self._axes.get(node)
        if axes is None:
            return np.eye(AXES)
        first, second = np.split(np.array(axes.points), 2)
        if axes.kind == "R":
            x = first / np.linalg.norm(first)
            z = np.cross(first, second)
        else:
            z = second - first
            arm = self.deck.coordinate[node] - first
            x = arm - (arm @ z) * z / (z @ z)
            if not np.linalg.norm(x) > 0:
                raise ValueError(
                    f"{axes.nodes.place}: *TRANSFORM: {self.deck.nodes.name(node)} lies on the axis"
                )
            x /= np.linalg.norm(x)
        z /= np.linalg.norm(z)
        return np.stack([x, np.cross(z, x), z])

    @cached_property
    def _axes(self) -> dict[int, Axes]:
        return {
            int(node): axes for axes in self.deck.axes for node in self.deck.nodes_of(axes.nodes)
        }
