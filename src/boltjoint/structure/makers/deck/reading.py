"""State of the reading of a deck: instance, system of coordinates, step, and what was read."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.deck.content import Coupling, Deck, Interaction, Material
from boltjoint.structure.makers.deck.labels import WHOLE, Indices
from boltjoint.structure.makers.deck.lines import Block, Place

Array = NDArray[np.float64]


def _none() -> tuple[Array, Array]:
    return np.eye(3), np.zeros(3)


@dataclass
class Reading:
    """What is known while a deck is read.

    Attributes
    ----------
    deck
        What was read.
    kinds
        Kinds of elements that are read as others.
    scope
        Name of the instance in capitals, empty outside.
    motion
        Rotation and translation of the instance.
    system
        Directions, as rows, and origin in which nodes are given.
    step
        Number of the step, 0 before all.
    """

    deck: Deck
    kinds: Mapping[str, str]
    scope: str = WHOLE
    motion: tuple[Array, Array] = field(default_factory=_none)
    system: tuple[Array, Array] = field(default_factory=_none)
    step: int = 0
    material: Material | None = None
    interaction: Interaction | None = None
    coupling: Coupling | None = None
    instances: set[str] = field(default_factory=set)
    coordinates: list[Array] = field(default_factory=list)
    node_places: list[tuple[Place, int]] = field(default_factory=list)
    connectivity: list[tuple[str, str, Indices, Indices, Block]] = field(default_factory=list)

    def add_nodes(self, label: Indices, coordinate: Array, block: Block) -> None:
        """Add nodes, whose coordinates are turned into those of the whole."""
        axes, origin = self.system
        rotation, translation = self.motion
        self.deck.nodes.add(self.scope, label)
        self.coordinates.append((coordinate @ axes + origin) @ rotation.T + translation)
        self.node_places.append((block.place, len(label)))

    def add_elements(self, kind: str, label: Indices, node: Indices, block: Block) -> None:
        """Add elements, whose nodes may be told later."""
        place = self.deck.numbers.add(self.scope, label)
        self.connectivity.append((self.scope, kind, place, node, block))

    def place_of_node(self, index: int) -> Place:
        """Keyword that defined a node."""
        for place, count in self.node_places:
            if index < count:
                return place
            index -= count
        raise IndexError(index)
