"""What a study asks of the description of a structure, whatever makes it, and its size."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, Self

from boltjoint.config.bolts import Shank, bolt_size
from boltjoint.config.entries import Entry
from boltjoint.config.excitation import Point
from boltjoint.config.types import Positive, Problems
from boltjoint.names import Preload

if TYPE_CHECKING:
    from boltjoint.config.gap_map import GapMap


#: more than any machine can count: sizes beyond it would overflow
COUNTLESS = 1e30


class MeshSize(NamedTuple):
    """Nodes, elements and contact pairs of the mesh of an assembly."""

    nodes: int
    elements: int
    pairs: int


class Divisions(Protocol):
    """What of a half lap its size follows from: a ``LapJoint`` has it."""

    @property
    def bar(self) -> Any: ...  # noqa: ANN401

    @property
    def bolts(self) -> Any: ...  # noqa: ANN401

    @property
    def mesh(self) -> Any: ...  # noqa: ANN401

    @property
    def bolt_count(self) -> int:
        """Number of bolts."""

    @property
    def bolt_positions_mm(self) -> Sequence[float]:
        """Places of the bolts along the lap [mm]."""

    @property
    def elements_outside_lap(self) -> Sequence[float]:
        """Elements along each part of the bars outside the lap."""

    @property
    def layers_in_washer(self) -> float:
        """Elements through the thickness of a washer; 0 without any."""

    @property
    def rings_head_to_washer_edge(self) -> int:
        """Rings of elements between the edges of head and washer."""


def mesh_size(assembly: Divisions) -> MeshSize:
    """Size of the mesh of an assembly, by counting its divisions."""
    mesh = assembly.mesh
    across, along, layers = (
        mesh.ring_cells_across_width,
        mesh.ring_cells_along_bar,
        mesh.layers_per_half_height,
    )
    bolts = assembly.bolt_count
    around = 2 * (across + along)
    rings_of_pairs, columns_of_pairs = _rings_and_columns_of_pairs(assembly)
    pairs = around * rings_of_pairs + (across + 1) * columns_of_pairs
    free = sum(int(min(count, COUNTLESS)) for count in assembly.elements_outside_lap)
    columns = (bolts - 1) * mesh.columns_between_bolt_cells + 2 * mesh.columns_at_each_lap_end
    rings = mesh.rings_under_head + mesh.rings_head_to_cell_edge

    in_washer = int(min(assembly.layers_in_washer, COUNTLESS))
    rim = assembly.rings_head_to_washer_edge
    of_bolt = bolt_size(assembly.bolts, mesh, (across, along), 2 * layers, rim, in_washer)
    # nodes are shared where a free bar meets its half of the lap
    free_nodes = (free + 2) * (across + 1) * (2 * layers + 1) - 2 * (across + 1) * (layers + 1)
    return MeshSize(
        nodes=2 * pairs * (layers + 1) + free_nodes + bolts * of_bolt.nodes,
        elements=2 * layers * (bolts * around * rings + columns * across)
        + 2 * layers * across * free
        + bolts * of_bolt.elements,
        pairs=pairs,
    )


def pairs_of_one_side(assembly: Divisions) -> int:
    """Coincident node pairs on the centre line and on one side of it."""
    rings, columns = _rings_and_columns_of_pairs(assembly)
    return (mesh_size(assembly).pairs + 2 * rings + columns) // 2


def longest_element_of_lap_mm(assembly: Divisions) -> float:
    """Longest element of the contact along the bar: of the columns and rings of the mesh."""
    mesh, bolts, positions = assembly.mesh, assembly.bolts, assembly.bolt_positions_mm
    cell, seat = mesh.bolt_cell_length_mm, bolts.seat_diameter_mm
    in_washer = assembly.rings_head_to_washer_edge
    # contradictions, as of a washer with no ring beyond it, are reported on their own
    beyond = max(1, mesh.rings_head_to_cell_edge - in_washer)
    pitches = (right - left for left, right in pairwise(positions))
    return max(
        cell / mesh.ring_cells_along_bar,
        (bolts.head_diameter_mm - bolts.hole_diameter_mm) / 2 / mesh.rings_under_head,
        (seat - bolts.head_diameter_mm) / 2 / max(1, in_washer),
        (cell - seat) / 2 / beyond,
        (positions[0] - cell / 2) / mesh.columns_at_each_lap_end,
        (assembly.bar.lap_mm - positions[-1] - cell / 2) / mesh.columns_at_each_lap_end,
        *((pitch - cell) / mesh.columns_between_bolt_cells for pitch in pitches),
    )


def _rings_and_columns_of_pairs(assembly: Divisions) -> tuple[int, int]:
    """Rings of contact pairs around all holes, and columns across the bar that are in no ring."""
    mesh, bolts = assembly.mesh, assembly.bolt_count
    rings = mesh.rings_under_head + mesh.rings_head_to_cell_edge + 1
    between = (bolts - 1) * (mesh.columns_between_bolt_cells - 1)
    return bolts * rings, between + 2 * mesh.columns_at_each_lap_end


class Described(Entry):
    """A description of a structure in a YAML file."""

    type: str
    """Kind of structure, by which the rest is read."""
    preload_N: Positive | None = None
    """Preload of each bolt of cases that give none; the contact is tabulated while no case uses the
    assembly."""

    #: whether its maker meshes it, and draws the mesh
    HAS_MESH: ClassVar[bool] = False
    #: whether there are solid bodies of any cells, which the figures of all makers show
    HAS_SOLIDS: ClassVar[bool] = False
    #: key of the initial gap
    GAP_KEY: ClassVar[str] = "contact.gap_um"
    #: whole numbers that name something, which do not vary in sweeps
    NAMING_KEYS: ClassVar[frozenset[str]] = frozenset()
    #: surfaces on which a load may be distributed
    LOADED_SURFACES: ClassVar[tuple[str, ...]] = ()

    @property
    def named_files(self) -> tuple[str, ...]:
        """Files that it names, seen from the folder of the study."""
        return ()

    @property
    def folder(self) -> Path:
        """Folder of the study, in which the files lie."""
        return Path()

    def in_folder(self, folder: Path) -> Self:
        """The same description, whose files lie in a folder; itself where there are none."""
        return self

    def conflicts_of_files(self) -> Problems:
        """What is wrong with its files, as far as it is told without reading all of them."""
        yield from ()

    @property
    @abstractmethod
    def bolt_count(self) -> int:
        """Number of bolts."""

    @property
    def bolt_names(self) -> tuple[str, ...]:
        """Names of the bolts, in the order of their preloads."""
        return tuple(f"bolt {number + 1}" for number in range(self.bolt_count))

    @property
    def own_preload(self) -> Preload | None:
        """That of cases which give none; None where the assembly does not tell one either."""
        return None if self.preload_N is None else Preload.of(self.preload_N)

    @property
    def input_names(self) -> tuple[str, ...]:
        """Places by name where forces may act, the first one by default."""
        return ()

    @property
    def output_names(self) -> tuple[str, ...]:
        """Places by name where motion may be read, the first one being the output point."""
        return ()

    @property
    def has_support(self) -> bool:
        """Whether it is held, so that its supports may be shaken."""
        return False

    @property
    def contact_pairs(self) -> int:
        """Number of contact points."""
        return self.size.pairs

    @property
    def pairs_of_one_side(self) -> int:
        """Contact points of which the others are mirror images; all where there are none."""
        return self.contact_pairs

    @property
    def has_mirror_images(self) -> bool:
        """Whether a plane of symmetry halves what is solved."""
        return self.pairs_of_one_side < self.contact_pairs

    @property
    @abstractmethod
    def size(self) -> MeshSize:
        """Nodes, elements and contact points."""

    @property
    @abstractmethod
    def has_initial_gap(self) -> bool:
        """Whether the surfaces stand apart before the bolts are tightened."""

    @property
    def given_loads(self) -> tuple[str, float] | None:
        """Key of normal loads that are given, and not found, and the preload they are of [N]."""
        return None

    @property
    def fixed_loads(self) -> tuple[str, str] | None:
        """Key by which loads do not grow with the preload, and their words; else None."""
        if self.given_loads is not None:
            return self.given_loads[0], "loads that are given"
        return (
            (self.GAP_KEY, "loads of a joint with an initial gap") if self.has_initial_gap else None
        )

    @property
    def has_modes_only(self) -> bool:
        """Whether nothing but its modes is known, so that no static shapes are found."""
        return False

    @property
    def damping_ratios(self) -> tuple[float, ...]:
        """Of its elastic modes, where they are known."""
        return ()

    @property
    def closes_contact(self) -> bool:
        """Whether modes have normal springs of the contact, so that laws must not."""
        return False

    @property
    @abstractmethod
    def surface_names(self) -> tuple[str, ...]:
        """Names of the surfaces in contact."""

    @property
    def gap_file(self) -> str | None:
        """File of the map of the initial gap; None where there is none."""
        return None

    @property
    def shank(self) -> Shank | None:
        """The shank of each bolt; None where not known."""
        return None

    def conflicts_of_gap(self, gap_maps: "Mapping[str, GapMap]") -> Problems:
        """What is wrong with the map of the initial gap; ``gap_maps`` by their files."""
        yield from ()

    def conflicts_of_ratios(self, ratios: Sequence[float]) -> Problems:
        """What is wrong with the preloads of the bolts over that of the case."""
        yield from ()

    @abstractmethod
    def conflicts_of_point(self, point: Point) -> Problems:
        """What is wrong with a point of a case."""
