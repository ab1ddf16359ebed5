"""A structure from a deck of Abaqus or CalculiX: file, units, contact, bolts, supports, points."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, ClassVar, Literal, NamedTuple, Self

from pydantic import Field, PrivateAttr

from boltjoint.config.described import Described, MeshSize
from boltjoint.config.entries import Entry
from boltjoint.config.excitation import NamedPoint, Point, Vector
from boltjoint.config.makers import maker
from boltjoint.config.types import (
    DeckFile,
    DeckName,
    Description,
    ElementKindName,
    Factorisation,
    KeyPath,
    Name,
    NotNegative,
    Number,
    Positive,
    Problems,
    conflicts_of_factorisation,
)
from boltjoint.names import Preload

#: of one unit in m, kg and s
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048}
MASSES = {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237, "slug": 14.59390294}
MASSES |= {"slinch": 175.126835}
TIMES = {"s": 1.0, "ms": 1e-3}

#: kinds of solid elements that are known
Solid = Literal["C3D4", "C3D6", "C3D8", "C3D8I", "C3D8R", "C3D10", "C3D15", "C3D20", "C3D20R"]


class BoltsOfDeck(NamedTuple):
    """Names of the bolts of a deck, and the loads that it gives them; None where one has none."""

    names: tuple[str, ...]
    preload: Preload | None


class Summary(NamedTuple):
    """Sizes of the mesh of a deck, its bolts, and whether something is held."""

    size: MeshSize
    bolts: BoltsOfDeck
    has_support: bool


class Units(Entry):
    """Units in which a deck is written: all others follow from these three."""

    length: Literal["m", "cm", "mm", "in", "ft"]
    """Unit of coordinates."""
    mass: Literal["kg", "g", "t", "lb", "slug", "slinch"]
    """Unit of mass: t with mm, s and MPa; slinch is lbf s²/in, with inches and psi."""
    time: Literal["s", "ms"] = "s"
    """Unit of time."""

    @property
    def factors(self) -> tuple[float, float, float]:
        """Of one unit of length, mass and time in m, kg and s."""
        return LENGTHS[self.length], MASSES[self.mass], TIMES[self.time]

    @property
    def pascal(self) -> float:
        """Of one unit of pressure in Pa."""
        length, mass, time = self.factors
        return mass / length / time**2

    @property
    def newton(self) -> float:
        """Of one unit of force in N."""
        length, mass, time = self.factors
        return mass * length / time**2


class DeckMaterial(Entry):
    """What the deck does not say of a material, or says otherwise."""

    name: DeckName
    """Name of the material in the deck."""
    youngs_modulus_GPa: Positive | None = None
    """Young's modulus; by default that of the deck."""
    poissons_ratio: Annotated[Number, Field(gt=-1, lt=0.5)] | None = None
    """Poisson's ratio; by default that of the deck."""
    density_kg_per_m3: Positive | None = None
    """Density; by default that of the deck."""
    yield_strength_MPa: Positive | None = None
    """Yield strength, over which the stress at peaks is told; by default 355 MPa, of S355, where
    the material is steel."""


class ElementReading(Entry):
    """A kind of elements of the deck that is read as another of as many nodes."""

    kind: ElementKindName
    """Kind in the deck, as ``C3D8R`` or ``C3D10M``."""
    read_as: Solid
    """Kind that it becomes, as ``C3D8I``."""


class DeckContact(Entry):
    """Two surfaces in frictional contact."""

    name: Name = "contact"
    """Name of the contact in results."""
    surfaces: tuple[DeckName, DeckName]
    """Surfaces of element faces in the deck: side A, which has the contact points, and side B."""
    tangent: Literal["x", "y", "z"] | Vector = "x"
    """First tangent: its part in the plane of the surface counts; laws of one direction act along
    it."""
    penalty_N_per_m3: Positive = 1e15
    """Static normal contact stiffness for each unit of area."""
    friction_coefficient: NotNegative = 0.1
    """Coulomb friction during tightening."""
    points: Literal["faces", "nodes"] = "faces"
    """One contact point for each face of side A, or for each of its nodes, where faces have corner
    nodes alone."""
    largest_gap_mm: Positive | None = None
    """Distance up to which faces may meet; by default half the radius of the larger face."""

    @property
    def first_tangent(self) -> Vector:
        """Direction of the first tangent, of any length."""
        if isinstance(self.tangent, str):
            x, y, z = (float(axis == self.tangent) for axis in "xyz")
            return x, y, z
        return self.tangent

    def conflicts(self) -> Problems:
        if self.surfaces[0].upper() == self.surfaces[1].upper():
            yield ("surfaces", 1), "must be another surface than the first one"
        if not any(self.first_tangent):
            yield ("tangent",), "must not be zero"


class BoltPlane(Entry):
    """A plane across the shank of a bolt, in which faces of its elements lie."""

    point_mm: Vector
    """A point in the shank: the faces that hang together with the nearest one are the section."""
    normal: Vector
    """Axis of the bolt."""

    def conflicts(self) -> Problems:
        if not any(self.normal):
            yield ("normal",), "must not be zero"


class DeckBolt(Entry):
    """A bolt of the deck by its name in results: a section of it, two couplings or a plane."""

    name: Name
    """Name of the bolt in results."""
    section: DeckName | None = None
    """Surface of its pre-tension section, or number or set of its beam."""
    couplings: tuple[DeckName, DeckName] | None = None
    """Names of the couplings, or of the reference nodes or their sets, at head and nut, between
    which its tension acts."""
    plane: BoltPlane | None = None
    """Plane that parts its shank, where the deck has no section of it."""

    def conflicts(self) -> Problems:
        if [self.section, self.couplings, self.plane].count(None) != 2:
            yield ("section",), "or couplings, or plane must be given, and one of them alone"


class Ties(Entry):
    """How surfaces are tied."""

    tolerance_mm: Positive | None = None
    """Distance within which slave nodes are tied; by default that of each tie in the deck, or 0.05
    of the size of a master face."""
    adjust: Literal["near", "all", "none"] = "near"
    """Nodes that are moved onto the faces: those within a tenth of the size of a face, so that the
    others keep their place and offset; all, as Abaqus and CalculiX do; or none."""


class Deck(Described):
    """A structure from a deck of Abaqus or CalculiX: solid bodies, free or held.

    Constraints count before the first step alone. Pairs of ``contact`` have friction; other contact
    pairs of the deck are tied. Lengths of keys here are in mm, whatever the units of the deck.
    """

    GAP_KEY: ClassVar[str] = "initial_gap"
    HAS_SOLIDS: ClassVar[bool] = True

    type: Literal["deck"]
    """Kind of structure."""
    description: Description = ""
    """Description of the structure in one line; no result depends on it."""
    file: DeckFile
    """The deck; decks and meshes, of gmsh or as VTU files, that it includes lie in the folder that
    holds config/ too."""
    units: Units
    materials: tuple[DeckMaterial, ...] = ()
    """What the deck does not say of its materials, as densities."""
    elements: tuple[ElementReading, ...] = ()
    """Kinds of elements that are read as others; by default none."""
    hourglass_factor: Positive = 0.005
    """Stiffness of the hourglass modes of C3D8R over the shear modulus; by default about that of
    Abaqus."""
    mass: Literal["consistent", "reduced"] = "consistent"
    """Integration of the mass: exact, or at the points of CalculiX."""
    contact: Annotated[tuple[DeckContact, ...], Field(min_length=1)]
    """Pairs of surfaces with friction, in the order of their points."""
    base: Literal["open", "closed"] = "open"
    """Structure that modes and bases are those of: without contact; or, where that falls apart,
    with normal springs of the points that are closed under preload."""
    initial_gap: Literal["closed", "from deck"] = "closed"
    """Gap between the surfaces before tightening: closed, so that they touch wherever they face
    each other; or the distances of the deck."""
    bolts: Literal["from deck"] | Annotated[tuple[DeckBolt, ...], Field(min_length=1)] = "from deck"
    """Bolts in the order of their preloads; by default the pre-tension sections of the deck, or
    pairs of reference nodes that equations join and opposite forces load."""
    ties: Ties = Ties()
    supports: (
        Literal["from deck", "none"] | Annotated[tuple[DeckName, ...], Field(min_length=1)]
    ) = "from deck"
    """Held nodes: those of the deck before its first step, none, or sets of nodes."""
    points: tuple[NamedPoint, ...] = ()
    """Places where forces may act and motion be read; the first is the output point."""
    factorisation: Factorisation = "auto"
    """Factors of the stiffness: those of SuperLU in an ordering of minimum degree; in one by nested
    dissection (METIS), with about three quarters of the entries in half the time; or PARDISO, with
    half the memory and a quarter of the time, of Intel processors and their like. The last two need
    packages of ``boltjoint[fast]``. ``auto`` is nested dissection from 30,000 degrees of freedom
    on, where it is installed, else SuperLU."""
    _folder: Path = PrivateAttr(Path())
    _summary: Summary | None = PrivateAttr(None)
    _bolts_of_deck: BoltsOfDeck | None = PrivateAttr(None)

    @property
    def named_files(self) -> tuple[str, ...]:
        """The deck and all files that it includes."""
        return maker(self.type).files_of(self, self._folder) or (self.file,)

    @property
    def folder(self) -> Path:
        """Folder of the study, in which the files lie."""
        return self._folder

    def in_folder(self, folder: Path) -> Self:
        """The same description, whose files lie in a folder."""
        copy = self.model_copy()
        copy._folder = folder
        copy._summary = copy._bolts_of_deck = None
        return copy

    @property
    def summary(self) -> Summary:
        """Sizes, bolts and supports; a ``ValueError`` where the deck does not tell them."""
        if self._summary is None:
            self._summary = maker(self.type).summary_of(self, self._folder)
        return self._summary

    @property
    def bolts_of_deck(self) -> BoltsOfDeck:
        """Those of the summary, or read without it; a ``ValueError`` where the deck has none."""
        if self._summary is not None:
            return self._summary.bolts
        if self._bolts_of_deck is None:
            self._bolts_of_deck = maker(self.type).bolts_in(self, self._folder)
        return self._bolts_of_deck

    @property
    def size(self) -> MeshSize:
        """Nodes, elements and contact points."""
        return self.summary.size

    @property
    def bolt_count(self) -> int:
        """Number of bolts."""
        return len(self.bolt_names if self.wanted_bolts is None else self.wanted_bolts)

    @property
    def wanted_bolts(self) -> tuple[DeckBolt, ...] | None:
        """``bolts``; None where they are all those of the deck."""
        return None if isinstance(self.bolts, str) else self.bolts

    @property
    def bolt_names(self) -> tuple[str, ...]:
        """Names of ``bolts``, or those of the deck."""
        return self.bolts_of_deck.names

    @property
    def own_preload(self) -> Preload | None:
        """``preload_N``, or the loads of the deck."""
        return super().own_preload or self.bolts_of_deck.preload

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of ``points``."""
        return tuple(point.name for point in self.points)

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of ``points``."""
        return self.input_names

    @property
    def has_support(self) -> bool:
        """Whether something is held."""
        if isinstance(self.supports, str):
            return self.supports != "none" and self.summary.has_support
        return True

    @property
    def has_initial_gap(self) -> bool:
        """Whether the surfaces may stand apart before the bolts are tightened."""
        return self.initial_gap == "from deck"

    @property
    def closes_contact(self) -> bool:
        """Whether modes have normal springs of the contact."""
        return self.base == "closed"

    @property
    def surface_names(self) -> tuple[str, ...]:
        """Names of the surfaces in contact."""
        return tuple(surface.name for surface in self.contact)

    @property
    def kinds(self) -> dict[str, str]:
        """Kinds of elements that are read as others."""
        return {elements.kind: elements.read_as for elements in self.elements}

    def conflicts_of_files(self) -> Problems:
        """What the deck does not hold."""
        try:
            _ = self.summary
        except ValueError as error:
            yield (), str(error)

    def conflicts_of_point(self, point: Point) -> Problems:
        """A point: the nearest node is taken, wherever it lies."""
        yield from ()

    def conflicts(self) -> Problems:
        yield from conflicts_of_factorisation(self.factorisation)
        named: list[tuple[str, str, Sequence[Entry]]] = [
            ("contact", "name", self.contact),
            ("materials", "name", self.materials),
            ("elements", "kind", self.elements),
            ("points", "name", self.points),
            ("bolts", "name", self.wanted_bolts or ()),
        ]
        for key, field, entries in named:
            yield from _twice((key,), field, entries)
        if self.closes_contact and self.has_initial_gap:
            sentence = "must be closed with base: closed, whose points are so at any preload"
            yield ("initial_gap",), sentence
        seen: dict[frozenset[str], int] = {}
        for index, surface in enumerate(self.contact):
            pair = frozenset(name.upper() for name in surface.surfaces)
            if pair in seen:
                yield ("contact", index, "surfaces"), "must not be given twice, or the other way"
            seen[pair] = index


def _twice(path: KeyPath, key: str, entries: Sequence[Entry]) -> Problems:
    seen: set[str] = set()
    for index, entry in enumerate(entries):
        value = str(getattr(entry, key)).upper()
        if value in seen:
            yield (*path, index, key), "must not appear twice"
        seen.add(value)
