"""Assembly: bars, bolts, mesh, material, excitation and output point."""

from itertools import pairwise
from typing import Annotated, Any

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from boltjoint.config.entries import Entry
from boltjoint.config.gap import ELEMENTS_IN_WAVE, Gap, GapShape
from boltjoint.config.points import Point
from boltjoint.config.types import (
    INTEGRAL,
    Count,
    Description,
    NotNegative,
    Number,
    Positive,
    Problems,
)


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


class Material(Entry):
    """Linear elastic material of bars and bolts."""

    youngs_modulus_GPa: Positive
    """Young's modulus."""
    poissons_ratio: Annotated[Number, Field(ge=0, lt=0.5)]
    """Poisson's ratio."""
    density_kg_per_m3: Positive
    """Mass density."""


class Bolts(Entry):
    """Row of equal bolts on the centre line of the lap."""

    positions_from_lap_start_mm: Annotated[tuple[Positive, ...], Field(min_length=1)] | None = None
    """Bolt axes, ascending, measured along the bar from the clamped side's end of the lap. The bolt
    cells lie inside the lap and apart from each other. Or give ``number`` and ``pitch_mm``."""
    number: Annotated[int, Field(strict=True, ge=1, le=1000), INTEGRAL] | None = None
    """Number of bolts, in place of their positions: they are centred in the lap."""
    pitch_mm: Positive | None = None
    """Distance between the axes of two bolts, with ``number``; of one bolt there is none."""
    shank_diameter_mm: Positive
    """Diameter of the shank."""
    hole_diameter_mm: Positive
    """Diameter of the clearance hole, greater than that of the shank."""
    head_diameter_mm: Positive
    """Outer diameter of head and nut, both modelled round: greater than that of the hole, less than
    the width of the bar and the length of a bolt cell."""
    head_height_mm: Positive
    """Height of the head."""
    nut_height_mm: Positive
    """Height of the nut."""

    def conflicts(self) -> Problems:
        positions, row = self.positions_from_lap_start_mm, (self.number, self.pitch_mm)
        if positions is not None:
            for key, value in zip(("number", "pitch_mm"), row, strict=True):
                if value is not None:
                    yield (key,), "must not stand beside positions_from_lap_start_mm"
        elif self.number is None:
            yield ("positions_from_lap_start_mm",), "is missing: or give number and pitch_mm"
        elif self.number > 1 and self.pitch_mm is None:
            yield ("pitch_mm",), "is missing: distance between the axes of two bolts"
        elif self.number == 1 and self.pitch_mm is not None:
            yield ("pitch_mm",), "must not be given with one bolt"
        for outer, inner in (("hole", "shank"), ("head", "hole")):
            least = getattr(self, f"{inner}_diameter_mm")
            if getattr(self, key := f"{outer}_diameter_mm") <= least:
                yield (key,), f"must be greater than the {inner}'s diameter of {least:g} mm"


class Mesh(Entry):
    """Divisions of the mesh, in numbers of elements unless a length.

    Each bolt sits in a rectangular cell as wide as the bar, with rings of elements around the hole;
    columns of elements fill the lap between and beside the cells. The divisions also set the number
    of contact pairs, 1370 and 1693 in the assemblies given here.
    """

    ring_cells_across_width: Annotated[int, Field(strict=True, ge=2, multiple_of=2), INTEGRAL]
    """Elements across the width of the bar; even, so that nodes lie on the centre line."""
    ring_cells_along_bar: Annotated[int, Field(strict=True, ge=2), INTEGRAL]
    """Elements along each long side of a bolt cell."""
    rings_under_head: Count
    """Rings of elements between the edge of the hole and the edge of the head."""
    rings_head_to_cell_edge: Count
    """Rings of elements between the edge of the head and the edge of the bolt cell."""
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


class StaticContact(Entry):
    """Contact between the bars during tightening of the bolts."""

    penalty_N_per_m3: Positive = 1e15
    """Normal contact stiffness for each unit of area."""
    friction_coefficient: NotNegative = 0.1
    """Coulomb friction between the bars during tightening."""
    gap_um: Gap | None = None
    """Gap between the surfaces as they touch before the bolts are tightened: its shape, or a CSV
    file of it, seen from the folder of ``config/``; flat by default. See *Form error*."""

    @property
    def gap_file(self) -> str | None:
        """File of the map of the gap; None where there is none."""
        return self.gap_um if isinstance(self.gap_um, str) else None

    @model_serializer(mode="wrap")
    def _without_form_error(self, fields: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # results of flat surfaces do not depend on a key that they do not have
        content = fields(self)
        if content.get("gap_um", self) is None:
            del content["gap_um"]
        return content


class Assembly(Entry):
    """Two bars with a half-lap joint, clamped at one end and held by a row of bolts.

    x runs along the bars from the clamp, y across the width from the centre line, and z upwards
    from the plane of contact.
    """

    description: Description = ""
    """Description of the assembly in one line; no result depends on it."""
    bar: Bar
    material: Material
    bolts: Bolts
    mesh: Mesh
    contact: StaticContact = StaticContact()
    preload_N: Positive | None = None
    """Preload of each bolt, to tabulate the contact while no case uses the assembly."""

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
    def contact_pairs(self) -> int:
        """Coincident node pairs of the plane of contact, by counting the mesh divisions."""
        mesh = self.mesh
        around = 2 * (mesh.ring_cells_across_width + mesh.ring_cells_along_bar)
        return around * self._rings_of_pairs + (mesh.ring_cells_across_width + 1) * self._columns

    @property
    def pairs_of_one_side(self) -> int:
        """Contact pairs on the centre line and on one side; the others are mirror images."""
        on_centre_line = 2 * self._rings_of_pairs + self._columns
        return (self.contact_pairs + on_centre_line) // 2

    @property
    def _rings_of_pairs(self) -> int:
        rings = self.mesh.rings_under_head + self.mesh.rings_head_to_cell_edge
        return len(self.bolt_positions_mm) * (rings + 1)

    @property
    def _columns(self) -> int:
        """Columns of contact pairs across the bar that belong to no ring."""
        mesh, bolts = self.mesh, len(self.bolt_positions_mm)
        between = (bolts - 1) * (mesh.columns_between_bolt_cells - 1)
        return between + 2 * mesh.columns_at_each_lap_end

    @property
    def _longest_element_of_lap_mm(self) -> float:
        """Longest element of the contact along the bar: of the columns and rings of the mesh."""
        mesh, bolts, positions = self.mesh, self.bolts, self.bolt_positions_mm
        cell = mesh.bolt_cell_length_mm
        pitches = (right - left for left, right in pairwise(positions))
        return max(
            cell / mesh.ring_cells_along_bar,
            (bolts.head_diameter_mm - bolts.hole_diameter_mm) / 2 / mesh.rings_under_head,
            (cell - bolts.head_diameter_mm) / 2 / mesh.rings_head_to_cell_edge,
            (positions[0] - cell / 2) / mesh.columns_at_each_lap_end,
            (self.bar.lap_mm - positions[-1] - cell / 2) / mesh.columns_at_each_lap_end,
            *((pitch - cell) / mesh.columns_between_bolt_cells for pitch in pitches),
        )

    def conflicts(self) -> Problems:
        yield from self._conflicts_of_head()
        yield from self._conflicts_of_waviness()
        if self.bolts.positions_from_lap_start_mm is not None:
            yield from self._conflicts_of_positions(self.bolts.positions_from_lap_start_mm)
        else:
            yield from self._conflicts_of_row()

    def _conflicts_of_head(self) -> Problems:
        for limit, what in (
            (self.bar.width_mm, "the bar's width"),
            (self.mesh.bolt_cell_length_mm, "the bolt cell's length"),
        ):
            if self.bolts.head_diameter_mm >= limit:
                yield ("bolts", "head_diameter_mm"), f"must be less than {what} of {limit:g} mm"

    def _conflicts_of_waviness(self) -> Problems:
        gap, shortest = self.contact.gap_um, ELEMENTS_IN_WAVE * self._longest_element_of_lap_mm
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
        # half an element from the clamp the nearest node is as far in it as beyond it
        free_mm = bar.free_length_mm[0] / self.elements_outside_lap[0] / 2
        if 0 <= round(point.x_mm, 6) <= round(free_mm, 6):
            sentence = f"is in the clamp, where no mode moves: must be more than {free_mm:g} mm"
            yield ("x_mm",), sentence
