"""Half lap of two bars: bars, bolts, mesh, material, excitation and output point.

Its mesh is made in ``structure.makers.half_lap``, of bolts as ``config.bolts`` describes them.
"""

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, get_args

from pydantic import Field

from boltjoint.config.bolts import (
    Bolts,
    Material,
    Shank,
    TighteningContact,
    layers_of_washer,
    rings_of_rim,
)
from boltjoint.config.described import (
    Described,
    MeshSize,
    longest_element_of_lap_mm,
    mesh_size,
    pairs_of_one_side,
)
from boltjoint.config.entries import Entry, EntryWithLaterKeys
from boltjoint.config.excitation import Point, Surface
from boltjoint.config.gap_map import ELEMENTS_IN_WAVE, Gap, GapShape
from boltjoint.config.types import (
    INTEGRAL,
    Count,
    Description,
    KeyPath,
    Positive,
    Problems,
)

if TYPE_CHECKING:
    from boltjoint.config.gap_map import GapMap


class Bar(Entry):
    """Dimensions of the two bars."""

    width_mm: Positive
    """Width of both bars (y), greater than the diameter of the bolt heads."""
    height_mm: Positive
    """Height of a bar outside the lap (z); in the lap each bar has half of it."""
    free_length_mm: tuple[Positive, Positive]
    """Lengths outside the lap: from the clamp to the lap, and from the lap to the free end."""
    lap_mm: Positive
    """Length of the lap (x), greater than that of all bolt cells."""

    @property
    def length_mm(self) -> float:
        """Length of the whole assembly, from the clamp to the free end."""
        return self.free_length_mm[0] + self.lap_mm + self.free_length_mm[1]


class Mesh(EntryWithLaterKeys):
    """Divisions of the mesh, in numbers of elements unless a length.

    Each bolt sits in a rectangular cell as wide as the bar, with rings of elements around the hole;
    columns of elements fill the lap between and beside the cells. The divisions also set the number
    of contact pairs, 1370 and 1693 in the assemblies given here. A drawing of *Your own joint*
    (``docs/studies.md``) shows where each of them acts.
    """

    LATER_KEYS = frozenset({"rings_head_to_washer_edge", "layers_in_washer"})

    ring_cells_across_width: Annotated[int, Field(strict=True, ge=2, multiple_of=2), INTEGRAL]
    """Elements across the width of the bar; even, so that nodes lie on the centre line."""
    ring_cells_along_bar: Annotated[int, Field(strict=True, ge=2), INTEGRAL]
    """Elements along each long side of a bolt cell."""
    rings_under_head: Count
    """Rings of elements between the edge of the hole and the edge of the head."""
    rings_head_to_cell_edge: Count
    """Rings of elements between the edge of the head and the edge of the bolt cell; at least 2 with
    a washer that is wider than the head."""
    bolt_cell_length_mm: Positive
    """Length of a bolt cell along the bar, half of it on each side of the bolt's axis: greater than
    the diameter of the head, less than the distance between bolts."""
    columns_between_bolt_cells: Count
    """Elements along the bar between two bolt cells."""
    columns_at_each_lap_end: Count
    """Elements along the bar between the outermost bolt cells and the ends of the lap."""
    layers_per_half_height: Count
    """Elements through half the height of a bar."""
    element_length_free_mm: Positive
    """Approximate length of the elements outside the lap."""
    rings_in_shank: Count
    """Rings of elements in the shank of a bolt."""
    layers_in_head: Count
    """Elements through the height of a head, and of a nut."""
    rings_head_to_washer_edge: Count | None = None
    """Rings of ``rings_head_to_cell_edge`` that lie under a washer wider than the head, of which
    one at least lies beyond it; by default the washer's share of the way to the nearest edge."""
    layers_in_washer: Count | None = None
    """Elements through the thickness of a washer; by default about as thick as those of a
    head."""


class StaticContact(EntryWithLaterKeys, TighteningContact):
    """Contact between the bars during tightening of the bolts."""

    LATER_KEYS = frozenset({"gap_um"})

    gap_um: Gap | None = None
    """Gap between the surfaces as they touch before the bolts are tightened: its shape, or a CSV
    file of it, seen from the folder of ``config/``; flat by default. See *Form error*."""


class LapJoint(Described):
    """Two bars with a half-lap joint, clamped at one end or free, and held by a row of bolts.

    x runs along the bars from the clamp, y across the width from the centre line, and z upwards
    from the plane of contact.
    """

    HAS_MESH: ClassVar[bool] = True
    LOADED_SURFACES: ClassVar[tuple[str, ...]] = get_args(Surface)

    type: Literal["half_lap"] = "half_lap"
    """Kind of structure: half laps need not name it."""
    description: Description = ""
    """Description of the assembly in one line; no result depends on it."""
    bar: Bar
    support: Literal["clamp", "none"] = "clamp"
    """How it is held: clamped at the end of the lower bar, or not at all. Six rigid-body modes, at
    0 Hz, then come before those that ``free-N`` counts."""
    material: Material
    """Linear elastic material of the bars, and of bolts and washers that are given no other."""
    bolts: Bolts
    mesh: Mesh
    contact: StaticContact = StaticContact()

    @property
    def bolt_count(self) -> int:
        """Number of bolts."""
        return len(self.bolt_positions_mm)

    @property
    def size(self) -> MeshSize:
        """Nodes, elements and contact pairs of the mesh."""
        return mesh_size(self)

    @property
    def surface_names(self) -> tuple[str, ...]:
        """The one surface of the lap."""
        return ("lap",)

    @property
    def input_names(self) -> tuple[str, ...]:
        """The middle of the free end's top edge, along z."""
        return ("excitation",)

    @property
    def output_names(self) -> tuple[str, ...]:
        """The same place."""
        return ("output",)

    @property
    def has_support(self) -> bool:
        """Whether it is clamped."""
        return self.support == "clamp"

    @property
    def named_files(self) -> tuple[str, ...]:
        """The map of the initial gap, if there is one."""
        return () if self.gap_file is None else (self.gap_file,)

    @property
    def has_initial_gap(self) -> bool:
        """Whether the surfaces of the bars have a form error."""
        return self.contact.gap_um is not None

    @property
    def gap_file(self) -> str | None:
        """File of the map of the initial gap; None where there is none."""
        return self.contact.gap_um if isinstance(self.contact.gap_um, str) else None

    @property
    def shank(self) -> Shank:
        """The shank of each bolt."""
        return self.bolts.shank_in(self.material)

    def conflicts_of_gap(self, gap_maps: "Mapping[str, GapMap]") -> Problems:
        """What is wrong with the map of the initial gap; ``gap_maps`` by their files."""
        if self.gap_file is not None and self.gap_file in gap_maps:
            conflicts = gap_maps[self.gap_file].conflicts(self.bar.lap_mm, self.bar.width_mm)
            yield from ((("contact", "gap_um"), sentence) for sentence in conflicts)

    @property
    def default_point(self) -> Point:
        """Middle of the free end's top edge, along z: the default of excitation and sensors."""
        return Point(x_mm=self.bar.length_mm, y_mm=0.0, z_mm=self.bar.height_mm / 2, direction="z")

    @property
    def bolt_positions_mm(self) -> tuple[float, ...]:
        """Axes of the bolts from the clamped side's end of the lap."""
        if self.bolts.positions_from_lap_start_mm is not None:
            return self.bolts.positions_from_lap_start_mm
        number, pitch = self.bolts.number or 1, self.bolts.pitch_mm or 0.0
        return tuple(self.bar.lap_mm / 2 + pitch * (n - (number - 1) / 2) for n in range(number))

    @property
    def elements_outside_lap(self) -> tuple[float, float]:
        """Elements along the bars from the clamp to the lap, and from the lap to the free end."""
        wanted = self.mesh.element_length_free_mm
        # whole, but no int: the quotient of what is allowed may be infinite
        before, behind = (max(1.0, round(length / wanted, 0)) for length in self.bar.free_length_mm)
        return before, behind

    @property
    def bolt_material(self) -> Material:
        """Material of the bolts."""
        return self.bolts.material_in(self.material)

    @property
    def washer_material(self) -> Material:
        """Material of the washers."""
        return self.bolts.material_of_washers_in(self.material)

    @property
    def rings_head_to_washer_edge(self) -> int:
        """Rings of elements under the washers beyond the heads; 0 where washers are not wider."""
        given = self.mesh.rings_head_to_washer_edge
        if self.bolts.has_wide_washers and given is not None:
            return given
        cell = min(self.mesh.bolt_cell_length_mm, self.bar.width_mm)
        return rings_of_rim(self.bolts, self.mesh, cell)

    @property
    def layers_in_washer(self) -> float:
        """Elements through the thickness of a washer; 0 without any."""
        given = self.mesh.layers_in_washer
        if self.bolts.washer is not None and given is not None:
            return given
        return layers_of_washer(self.bolts, self.mesh)

    @property
    def pairs_of_one_side(self) -> int:
        """Contact pairs on the centre line and on one side; the others are mirror images."""
        return pairs_of_one_side(self)

    def conflicts(self) -> Problems:
        yield from self._conflicts_of_head()
        yield from self._conflicts_of_washer()
        yield from self._conflicts_of_waviness()
        if self.bolts.positions_from_lap_start_mm is not None:
            yield from self._conflicts_of_positions(self.bolts.positions_from_lap_start_mm)
        else:
            yield from self._conflicts_of_row()

    def _conflicts_of_head(self) -> Problems:
        diameters: dict[KeyPath, float] = {
            ("bolts", "head_diameter_mm"): self.bolts.head_diameter_mm
        }
        if self.bolts.washer is not None:
            diameters["bolts", "washer", "diameter_mm"] = self.bolts.washer.diameter_mm
        for key, diameter in diameters.items():
            for limit, what in (
                (self.bar.width_mm, "the bar's width"),
                (self.mesh.bolt_cell_length_mm, "the bolt cell's length"),
            ):
                if diameter >= limit:
                    yield key, f"must be less than {what} of {limit:g} mm"

    def _conflicts_of_washer(self) -> Problems:
        mesh, rings = self.mesh, self.mesh.rings_head_to_cell_edge
        if self.bolts.washer is None:
            for key in ("rings_head_to_washer_edge", "layers_in_washer"):
                if getattr(mesh, key) is not None:
                    yield ("mesh", key), "must not be given without bolts.washer"
        elif self.bolts.has_wide_washers and rings < 2:
            yield (
                ("mesh", "rings_head_to_cell_edge"),
                "must be at least 2 with a washer that is wider than the head",
            )
        elif (chosen := mesh.rings_head_to_washer_edge) is not None and chosen >= rings:
            sentence = f"must be less than rings_head_to_cell_edge, which is {rings}"
            yield ("mesh", "rings_head_to_washer_edge"), sentence

    def _conflicts_of_waviness(self) -> Problems:
        gap, shortest = self.contact.gap_um, ELEMENTS_IN_WAVE * longest_element_of_lap_mm(self)
        if isinstance(gap, GapShape) and gap.wavelength_mm is not None:
            if round(gap.wavelength_mm - shortest, 6) < 0:
                yield (
                    ("contact", "gap_um", "wavelength_mm"),
                    f"must be at least {shortest:.4g} mm, {ELEMENTS_IN_WAVE} times the longest "
                    "element along the lap",
                )

    def _conflicts_of_row(self) -> Problems:
        number, pitch = self.bolts.number or 1, self.bolts.pitch_mm or 0.0
        cell, lap = self.mesh.bolt_cell_length_mm, self.bar.lap_mm
        if number > 1 and round(pitch - cell, 6) <= 0:
            sentence = f"must be more than {cell:g} mm, the length of a bolt cell"
            yield ("bolts", "pitch_mm"), sentence
        elif round(lap - (number - 1) * pitch - cell, 6) <= 0:
            if number == 1:
                yield ("bar", "lap_mm"), f"must be more than {cell:g} mm, the length of a bolt cell"
                return
            most = (lap - cell) / (number - 1)
            yield (
                ("bolts", "pitch_mm"),
                "puts the outermost bolt cells outside the lap: must be less than "
                f"{most:g} mm in the lap of {lap:g} mm",
            )

    def _conflicts_of_positions(self, positions: tuple[float, ...]) -> Problems:
        key, cell = ("bolts", "positions_from_lap_start_mm"), self.mesh.bolt_cell_length_mm
        # to a nanometre: less is a rounding error of the differences
        pitches = [round(right - left, 6) for left, right in pairwise(positions)]
        if any(pitch <= 0 for pitch in pitches):
            yield key, "must be ascending"
            return
        for index, pitch in enumerate(pitches, start=1):
            if pitch <= cell:
                sentence = f"is {pitch:g} mm from the bolt before it: must be more than {cell:g} mm"
                yield (*key, index), f"{sentence} from it, the length of a bolt cell"
        for index, position in enumerate(positions):
            if round(min(position, self.bar.lap_mm - position) - cell / 2, 6) <= 0:
                yield (
                    (*key, index),
                    f"puts the bolt's cell outside the lap: must be more than {cell / 2:g} mm "
                    f"(half a bolt cell) from both ends of the lap of {self.bar.lap_mm:g} mm",
                )

    def conflicts_of_point(self, point: Point) -> Problems:
        """What is wrong with a point of a case on this assembly."""
        bar = self.bar
        for name, low, high in (
            ("x_mm", 0.0, bar.length_mm),
            ("y_mm", -bar.width_mm / 2, bar.width_mm / 2),
            ("z_mm", -bar.height_mm / 2, bar.height_mm / 2),
        ):
            if not low <= round(getattr(point, name), 6) <= round(high, 6):
                yield (name,), f"must lie in the assembly, from {low:g} to {high:g} mm"
        if not self.has_support:
            return
        # half an element from the clamp the nearest node is as far in it as beyond it
        free_mm = bar.free_length_mm[0] / self.elements_outside_lap[0] / 2
        if 0 <= round(point.x_mm, 6) <= round(free_mm, 6):
            sentence = f"is in the support, where no mode moves: must be more than {free_mm:g} mm"
            yield ("x_mm",), sentence
