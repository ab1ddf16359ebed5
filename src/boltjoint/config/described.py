"""What a study asks of the description of a structure, whatever makes it."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING

from boltjoint.config.entries import Entry
from boltjoint.config.mesh_size import MeshSize
from boltjoint.config.points import Point
from boltjoint.config.types import Problems

if TYPE_CHECKING:
    from boltjoint.config.gap_map import GapMap


class Described(Entry):
    """A description of a structure in a YAML file."""

    @property
    @abstractmethod
    def bolt_count(self) -> int:
        """Number of bolts."""

    @property
    @abstractmethod
    def contact_pairs(self) -> int:
        """Number of contact points."""

    @property
    @abstractmethod
    def pairs_of_one_side(self) -> int:
        """Contact points of which the others are mirror images; all where there are none."""

    @property
    @abstractmethod
    def size(self) -> MeshSize:
        """Nodes, elements and contact points."""

    @property
    @abstractmethod
    def has_initial_gap(self) -> bool:
        """Whether the surfaces stand apart before the bolts are tightened."""

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
