"""What a deck says: nodes, elements, sets, constraints, bolts, contact; and how far it is read.

All is in the units of the deck and in its words; nothing is computed from it here.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.deck.labels import WHOLE, Indices, Members, Numbering, Sets, scoped
from boltjoint.structure.makers.deck.lines import Block, Place

Array = NDArray[np.float64]


class Reference(NamedTuple):
    """A node, or a set of nodes or elements, as a data line names it.

    ``text`` is a number or a name, seen from the instance ``scope`` where there is one.
    """

    text: str
    scope: str
    place: Place


class Elements(NamedTuple):
    """Elements of one kind: their places among all, those of their nodes, and their lines."""

    kind: str
    place: Indices
    node: Indices
    at: Place


class FacePiece(NamedTuple):
    """Faces of a surface: elements with the number of a face, or all that are free, or nodes."""

    reference: Reference
    face: int | None


@dataclass
class SurfaceLines:
    """A surface by its data lines; ``of_nodes`` where it is a set of nodes."""

    name: str
    place: Place
    of_nodes: bool
    pieces: list[FacePiece] = field(default_factory=list)


@dataclass
class Material:
    """An elastic material; None for what the deck does not say."""

    name: str
    place: Place
    youngs_modulus: float | None = None
    poissons_ratio: float | None = None
    density: float | None = None

    @property
    def elasticity(self) -> tuple[float, float]:
        """Young's modulus and Poisson's ratio; a ``ValueError`` where the deck does not say."""
        if self.youngs_modulus is None or self.poissons_ratio is None:
            raise ValueError(f"{self.place}: *MATERIAL {self.name} has no *ELASTIC")
        return self.youngs_modulus, self.poissons_ratio


class Section(NamedTuple):
    """Material of a set of solid elements."""

    elements: Reference
    material: str


class Beam(NamedTuple):
    """Material and cross-section of a set of beams: radius, or two widths.

    ``first_axis`` is the direction of the first width, as given: it need not be across the beam.
    """

    elements: Reference
    material: str
    kind: str
    sizes: tuple[float, ...]
    first_axis: tuple[float, ...]
    place: Place


class Tie(NamedTuple):
    """Nodes of one surface that move with the faces of another; tolerance None by default.

    ``is_adjusted`` where nodes may be moved onto the faces.
    """

    name: str
    slave: Reference
    master: Reference
    tolerance: float | None
    place: Place
    is_adjusted: bool = True


class Term(NamedTuple):
    """Coefficient of one displacement, 1 to 3, or rotation, 4 to 6, of a node."""

    node: Reference
    dof: int
    coefficient: float


class Equation(NamedTuple):
    """A sum of terms that is zero."""

    terms: tuple[Term, ...]
    place: Place


class Coupling(NamedTuple):
    """A reference node with the nodes of a surface or set: kinematic, or by their mean."""

    name: str
    kind: str
    reference: Reference
    nodes: Reference
    of_surface: bool
    dofs: tuple[int, ...]
    place: Place
    #: by the nodes of a set, where they are given
    weights: tuple[float, ...] = ()


class PretensionSection(NamedTuple):
    """A section of a bolt across a surface or a beam, whose shortening is a node's first dof."""

    node: Reference
    surface: Reference | None
    element: Reference | None
    normal: tuple[float, float, float]
    place: Place

    @property
    def name(self) -> str:
        """Name of the surface, or of the beam."""
        reference = self.surface or self.element
        return "" if reference is None else reference.text


class Boundary(NamedTuple):
    """Held displacements of nodes; ``step`` is 0 before all steps."""

    nodes: Reference
    first: int
    last: int
    value: float
    step: int


class Load(NamedTuple):
    """A force on nodes along a dof; ``step`` is 0 before all steps."""

    nodes: Reference
    dof: int
    force: float
    step: int


class ContactPair(NamedTuple):
    """Two surfaces in contact, by the law of an interaction."""

    slave: Reference
    master: Reference
    interaction: str
    place: Place


@dataclass
class Interaction:
    """Stiffness for each area and friction coefficient of contact, None where not given."""

    name: str
    stiffness: float | None = None
    friction_coefficient: float | None = None


class PointProperty(NamedTuple):
    """Mass of each element MASS of a set, or stiffness of each spring SPRINGA."""

    elements: Reference
    value: float


class Axes(NamedTuple):
    """Local directions of a set of nodes: fixed, or around an axis through two points."""

    nodes: Reference
    kind: str
    points: tuple[float, ...]


@dataclass
class Deck:
    """A deck as it was read.

    Attributes
    ----------
    file
        As seen from the folder of the study.
    coordinate
        Of all nodes, those of no element too, shape (nodes, 3).
    elements
        By kind, in the order of the deck.
    unused
        Keywords that were left out, with the places where they stand first and their number.
    """

    file: str
    nodes: Numbering = field(default_factory=lambda: Numbering("node"))
    numbers: Numbering = field(default_factory=lambda: Numbering("element"))
    coordinate: Array = field(default_factory=lambda: np.zeros((0, 3)))
    elements: list[Elements] = field(default_factory=list)
    surfaces: dict[str, SurfaceLines] = field(default_factory=dict)
    materials: dict[str, Material] = field(default_factory=dict)
    sections: list[Section] = field(default_factory=list)
    beams: list[Beam] = field(default_factory=list)
    ties: list[Tie] = field(default_factory=list)
    equations: list[Equation] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)
    rigid_bodies: list[Coupling] = field(default_factory=list)
    pretension: list[PretensionSection] = field(default_factory=list)
    boundaries: list[Boundary] = field(default_factory=list)
    loads: list[Load] = field(default_factory=list)
    contact: list[ContactPair] = field(default_factory=list)
    interactions: dict[str, Interaction] = field(default_factory=dict)
    masses: list[PointProperty] = field(default_factory=list)
    springs: list[PointProperty] = field(default_factory=list)
    axes: list[Axes] = field(default_factory=list)
    unused: dict[str, tuple[Place, int]] = field(default_factory=dict)
    steps: int = 0

    def __post_init__(self) -> None:
        self.node_sets = Sets(self.nodes, "NSET", self._nodes_of_elements)
        self.element_sets = Sets(self.numbers, "ELSET")

    def nodes_of(self, reference: Reference) -> Indices:
        """Nodes that a number or a name stands for."""
        return self._places(self.nodes, self.node_sets, reference)

    def node_of(self, reference: Reference) -> int:
        """The one node that a number or the name of a set of one stands for."""
        node = self.nodes_of(reference)
        if len(node) != 1:
            raise ValueError(
                f"{reference.place}: set {reference.text} has {len(node)} nodes: it must have one"
            )
        return int(node[0])

    def elements_of(self, reference: Reference) -> Indices:
        """Places of the elements that a number or a name stands for."""
        return self._places(self.numbers, self.element_sets, reference)

    def surface(self, reference: Reference) -> SurfaceLines:
        """The surface of a name."""
        name, scope = reference.text, reference.scope
        for key in (scoped(scope, name), name.upper()):
            if key in self.surfaces:
                return self.surfaces[key]
        raise ValueError(f"{reference.place}: there is no *SURFACE {name}")

    def kinds(self) -> Iterator[tuple[str, int]]:
        """Kinds of elements and their numbers."""
        count: dict[str, int] = {}
        for elements in self.elements:
            count[elements.kind] = count.get(elements.kind, 0) + len(elements.place)
        yield from count.items()

    def _places(self, numbering: Numbering, sets: Sets, reference: Reference) -> Indices:
        text, scope, place = reference
        instance, _, number = text.rpartition(".")
        if number.isdigit() and sets.key(scope, text) is None:
            within = instance.upper() or scope
            return numbering.places(within, np.array([int(number)]), place)
        return sets.places(scope, text, place)

    def _nodes_of_elements(self, members: Members) -> Indices:
        """Nodes of the elements of a set, of which a set of nodes is made."""
        wanted = self.element_sets.places(members.scope, members.nodes_of, members.place)
        nodes = [
            elements.node[np.isin(elements.place, wanted)].ravel() for elements in self.elements
        ]
        return np.unique(np.concatenate([*nodes, np.zeros(0, np.int64)]))


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
    orientation: str = ""
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
