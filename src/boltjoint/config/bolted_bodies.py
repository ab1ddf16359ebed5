"""What plates and flanges have in common: two bodies in contact that bolts hold together."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from boltjoint.config.bolts import (
    BoltDimensions,
    BoltSize,
    Material,
    Shank,
    TighteningContact,
    bolt_size,
    layers_of_washer,
    rings_of_rim,
)
from boltjoint.config.described import COUNTLESS, Described, MeshSize
from boltjoint.config.entries import Entry
from boltjoint.config.excitation import NamedPoint, Point
from boltjoint.config.grid import Grid, Lines
from boltjoint.config.types import (
    INTEGRAL,
    Count,
    Description,
    KeyPath,
    NotNegative,
    Positive,
    Problems,
)

#: sides of a cell over the diameter of the head or washer in it: at least, so that its corners lie
#: within, and at most where none is given
LEAST_CELL, MOST_CELL = 1.1, 2.0
#: bolts that are checked and counted within a moment
MOST_BOLTS = 1000


class BodyMesh(Entry):
    """Divisions of the mesh, in numbers of elements unless a length.

    Each bolt sits in a square cell with rings of elements around the hole. Lines through the edges
    of the cells, and between them, divide all of the bodies.
    """

    element_length_mm: Positive
    """Approximate length of the elements outside bolt cells."""
    bolt_cell_mm: Positive | None = None
    """Side of the bolt cells, at least 1.1 times the diameter of head or washer; by default twice
    that, or less where the next bolt or edge is nearer."""
    elements_along_cell: Annotated[int, Field(strict=True, ge=2, le=1000), INTEGRAL] = 4
    """Elements along each side of a bolt cell, as far as no lines of other cells cross it."""
    rings_under_head: Count = 1
    """Rings of elements between the edge of the hole and the edge of the head."""
    rings_head_to_cell_edge: Count = 2
    """Rings of elements between the edge of the head and the edge of the bolt cell; at least 2 with
    a washer that is wider than the head."""
    layers: tuple[Count, Count] = (2, 2)
    """Elements through the thickness of the lower and of the upper body."""
    rings_in_shank: Count = 1
    """Rings of elements in the shank of a bolt."""
    layers_in_head: Count = 1
    """Elements through the height of a head, and of a nut."""


class BoltedBodies(Described):
    """Two bodies in contact, the lower one held or free, that bolts hold together.

    z points upwards from the plane of contact, along the bolts, whose heads lie above.
    """

    HAS_SOLIDS: ClassVar[bool] = True

    description: Description = ""
    """Description of the assembly in one line; no result depends on it."""
    support: Literal["end", "none"] = "end"
    """How it is held: at the end of the lower body, or not at all. Six rigid-body modes, at 0 Hz,
    then come before those that ``free-N`` counts."""
    material: Material
    """Linear elastic material of the bodies, and of bolts and washers that are given no other."""
    bolts: BoltDimensions
    mesh: BodyMesh
    contact: TighteningContact = TighteningContact()
    points: tuple[NamedPoint, ...] = ()
    """Places where forces may act and motion be read; the first is the output point."""
    symmetry: Literal["none", "xz"] = "none"
    """Plane of symmetry of which one side is solved, the other moving as its mirror image: bolts,
    preloads, points and excitation must be symmetric about it. By default all is solved."""

    @property
    @abstractmethod
    def grid_mm(self) -> Grid:
        """Lines and cells of the plane of contact [mm, or rad along the second direction]."""

    @property
    @abstractmethod
    def extent_mm(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest x, y and z of both bodies [mm]."""

    @property
    @abstractmethod
    def bolt_positions_mm(self) -> tuple[tuple[float, float], ...]:
        """Axes of the bolts, x and y [mm]."""

    @property
    @abstractmethod
    def widest_cell_mm(self) -> float:
        """Side of the largest cells for which there is room [mm]."""

    @property
    @abstractmethod
    def size_beside(self) -> tuple[int, int]:
        """Nodes and elements of bodies outside the plane of contact, nodes within it left out."""

    @property
    def cell_mm(self) -> float:
        """Side of the bolt cells [mm]."""
        if self.mesh.bolt_cell_mm is not None:
            return self.mesh.bolt_cell_mm
        return min(MOST_CELL * self.bolts.seat_diameter_mm, self.widest_cell_mm)

    @property
    def fine_mm(self) -> float:
        """Length of elements along the sides of cells [mm]."""
        return self.cell_mm / self.mesh.elements_along_cell

    @property
    def rings_of_rim(self) -> int:
        """Rings of elements under the washers beyond the heads; 0 where washers are not wider."""
        return rings_of_rim(self.bolts, self.mesh, self.cell_mm)

    @property
    def layers_in_washer(self) -> int:
        """Elements through the thickness of a washer; 0 without any."""
        return int(min(layers_of_washer(self.bolts, self.mesh), COUNTLESS))

    @property
    def bolt_material(self) -> Material:
        """Material of the bolts."""
        return self.bolts.material_in(self.material)

    @property
    def washer_material(self) -> Material:
        """Material of the washers."""
        return self.bolts.material_of_washers_in(self.material)

    @property
    def bolt_count(self) -> int:
        """Number of bolts."""
        return len(self.bolt_positions_mm)

    @property
    def shank(self) -> Shank:
        """The shank of each bolt."""
        return self.bolts.shank_in(self.material)

    @property
    def size(self) -> MeshSize:
        """Nodes, elements and contact pairs of the mesh."""
        mesh, grid = self.mesh, self.grid_mm
        rings = mesh.rings_under_head + mesh.rings_head_to_cell_edge
        pairs, quads = grid.size(rings)
        nodes, elements = self.size_beside
        layers = sum(mesh.layers)
        nodes, elements = nodes + pairs * (layers + 2), elements + quads * layers
        for cell in grid.cells:
            along, across = grid.sides(cell)
            of_bolt = self._bolt_size((across, along), layers)
            nodes, elements = nodes + of_bolt.nodes, elements + of_bolt.elements
        return MeshSize(nodes, elements, pairs)

    def _bolt_size(self, sides: tuple[int, int], layers: int) -> BoltSize:
        rim, in_washer = self.rings_of_rim, self.layers_in_washer
        return bolt_size(self.bolts, self.mesh, sides, layers, rim, in_washer)

    @property
    def pairs_of_one_side(self) -> int:
        """Contact pairs on one side of the plane of symmetry; all where none is used."""
        pairs = self.contact_pairs
        return pairs if self.symmetry == "none" else (pairs + 1) // 2

    @property
    def surface_names(self) -> tuple[str, ...]:
        """The one surface between the bodies."""
        return ("interface",)

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
        """Whether it is held."""
        return self.support != "none"

    @property
    def has_initial_gap(self) -> bool:
        """Surfaces are flat."""
        return False

    def _lines(self, ends: Sequence[float], cells: Sequence[tuple[float, float]]) -> Lines:
        """Lines across a direction in mm."""
        return Lines.between(ends, cells, self.mesh.element_length_mm, self.fine_mm)

    def conflicts(self) -> Problems:
        mesh, given = self.mesh, self.mesh.bolt_cell_mm
        if self.bolts.has_wide_washers and mesh.rings_head_to_cell_edge < 2:
            yield (
                ("mesh", "rings_head_to_cell_edge"),
                "must be at least 2 with a washer that is wider than the head",
            )
        least, most = LEAST_CELL * self.bolts.seat_diameter_mm, self.widest_cell_mm
        if given is not None and not least <= given <= round(most, 6):
            sentence = (
                f"must be at least {least:.5g} mm, {LEAST_CELL} times the diameter of head or "
                f"washer, and at most {most:.5g} mm, for which there is room"
            )
            yield ("mesh", "bolt_cell_mm"), sentence
        names = self.input_names
        for index, point in enumerate(self.points):
            if point.name in names[:index]:
                yield ("points", index, "name"), "must not appear twice"
            place = dict(zip("xyz", point.near_mm, strict=True))
            for number, (axis, value) in enumerate(place.items()):
                if problem := self._outside(axis, value):
                    yield ("points", index, "near_mm", number), problem
            if self.symmetry != "none" and (point.near_mm[1] or point.direction == "y"):
                yield ("points", index), _OFF_PLANE

    def _outside(self, axis: str, value: float) -> str | None:
        low, high = self.extent_mm["xyz".index(axis)]
        if round(low, 6) <= round(value, 6) <= round(high, 6):
            return None
        return f"must lie in the assembly, {axis} from {low:g} to {high:g} mm"

    def conflicts_of_point(self, point: Point) -> Problems:
        """What is wrong with a point of a case on this assembly."""
        for axis in "xyz":
            if problem := self._outside(axis, getattr(point, f"{axis}_mm")):
                yield (f"{axis}_mm",), problem
        if self.symmetry != "none" and (point.y_mm or point.direction == "y"):
            yield ("y_mm",), _OFF_PLANE

    def conflicts_of_ratios(self, ratios: Sequence[NotNegative]) -> Problems:
        """Preloads that are not symmetric, where one half is solved."""
        if self.symmetry == "none":
            return
        of_place = dict(zip(_places(self.bolt_positions_mm), ratios, strict=True))
        for index, ((x, y), ratio) in enumerate(of_place.items()):
            if of_place[x, round(-y, 6) + 0.0] != ratio:
                yield (index,), "must be that of the bolt beyond the plane, with symmetry: xz"
                return

    def conflicts_of_symmetry(self) -> Problems:
        """Bolts that have no mirror image, where one half is solved."""
        if self.symmetry == "none":
            return
        places = _places(self.bolt_positions_mm)
        if {(x, round(-y, 6) + 0.0) for x, y in places} != set(places):
            yield ("symmetry",), "must be none: bolts are not symmetric about the plane of x and z"


_OFF_PLANE = "must lie on the plane of x and z and act in it, with symmetry: xz"


def _places(positions: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    # to a nanometre, and no negative zero
    return [(round(x, 6) + 0.0, round(y, 6) + 0.0) for x, y in positions]


def too_near(key: KeyPath, what: str, distance: float, share: float, seat: float) -> Problems:
    """A problem where bolts are nearer to something than a share of the diameter of their seats."""
    if round(distance - share * seat, 6) < 0:
        yield (
            key,
            f"leaves {max(distance, 0.0):.5g} mm {what}: must leave at least {share * seat:.5g} "
            f"mm, {share:g} times the diameter of head or washer",
        )
