"""What a study asks of the description of a structure, whatever makes it."""

from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Self

from boltjoint.config.entries import Entry
from boltjoint.config.excitation import Point
from boltjoint.config.mesh_size import MeshSize
from boltjoint.config.types import Positive, Problems

if TYPE_CHECKING:
    from boltjoint.config.gap_map import GapMap


class Described(Entry):
    """A description of a structure in a YAML file."""

    type: str
    """Kind of structure, by which the rest is read."""
    preload_N: Positive | None = None
    """Preload of each bolt, to tabulate the contact while no case uses the assembly."""

    #: whether there is a mesh of a half lap, which figures show
    HAS_MESH: ClassVar[bool] = False
    #: whether there are solid bodies of any other cells, which figures show
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
    def shank(self) -> tuple[float, float] | None:
        """Cross-section [m2] and Young's modulus [Pa] of the shanks; None where not known."""
        return None

    def conflicts_of_gap(self, gap_maps: "Mapping[str, GapMap]") -> Problems:
        """What is wrong with the map of the initial gap; ``gap_maps`` by their files."""
        yield from ()

    @abstractmethod
    def conflicts_of_point(self, point: Point) -> Problems:
        """What is wrong with a point of a case."""
