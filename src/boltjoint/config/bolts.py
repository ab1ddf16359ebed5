"""Bolts and washers of an assembly, and their materials."""

from typing import Annotated, Literal

from pydantic import Field

from boltjoint.config.entries import Entry, EntryWithLaterKeys
from boltjoint.config.types import INTEGRAL, Number, Positive, Problems, Several

#: what the keys of a material are called
MATERIAL_WORDS = {
    "youngs_modulus_GPa": "Young's modulus (GPa)",
    "poissons_ratio": "Poisson's ratio",
    "density_kg_per_m3": "density (kg/m³)",
}


class Material(Entry):
    """Linear elastic material."""

    youngs_modulus_GPa: Positive
    """Young's modulus."""
    poissons_ratio: Annotated[Number, Field(ge=0, lt=0.5)]
    """Poisson's ratio."""
    density_kg_per_m3: Positive
    """Mass density."""


class Washer(EntryWithLaterKeys):
    """Equal washers of all bolts, tied to the bars, and to head or nut."""

    LATER_KEYS = frozenset({"hole_diameter_mm", "material"})

    thickness_mm: Positive
    """Thickness of a washer; the shanks are longer by that of their washers."""
    diameter_mm: Positive
    """Outer diameter: at least that of the head, less than the width of the bar and the length of a
    bolt cell."""
    hole_diameter_mm: Positive | None = None
    """Diameter of the washer's hole, greater than that of the shank and at most that of the hole in
    the bars, which it is by default."""
    under: Several[Literal["head", "nut"]] = ("head", "nut")
    """Where washers lie."""
    material: Material | None = None
    """Linear elastic material of the washers; by default that of the bolts."""


class Bolts(EntryWithLaterKeys):
    """Row of equal bolts on the centre line of the lap."""

    LATER_KEYS = frozenset({"material", "washer"})

    positions_from_lap_start_mm: Annotated[tuple[Positive, ...], Field(min_length=1)] | None = None
    """Bolt axes, ascending, measured along the bar from the end of the lap that is nearer to the
    support. The bolt cells lie inside the lap and apart from each other. Or give ``number`` and
    ``pitch_mm``."""
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
    material: Material | None = None
    """Linear elastic material of the bolts; by default that of the bars."""
    washer: Washer | None = None
    """Washers under heads and nuts; none by default."""

    @property
    def narrow_hole_mm(self) -> float | None:
        """Diameter of the hole of washers that is narrower than that in the bars, if any."""
        own = None if self.washer is None else self.washer.hole_diameter_mm
        # to a nanometre: less is a rounding error
        return own if own is not None and round(self.hole_diameter_mm - own, 6) > 0 else None

    @property
    def has_narrow_washers(self) -> bool:
        """Whether there are washers with a hole narrower than that in the bars."""
        return self.narrow_hole_mm is not None

    @property
    def seat_diameter_mm(self) -> float:
        """Outer diameter of what is tied to the bars: of the washers, or of the heads."""
        return self.head_diameter_mm if self.washer is None else self.washer.diameter_mm

    @property
    def has_wide_washers(self) -> bool:
        """Whether there are washers that reach beyond the heads."""
        return round(self.seat_diameter_mm - self.head_diameter_mm, 6) > 0

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
        yield from self._conflicts_of_washer()

    def _conflicts_of_washer(self) -> Problems:
        if self.washer is None:
            return
        if self.washer.diameter_mm < self.head_diameter_mm:
            sentence = f"must be at least the head's diameter of {self.head_diameter_mm:g} mm"
            yield ("washer", "diameter_mm"), sentence
        own, shank, hole = (
            self.washer.hole_diameter_mm,
            self.shank_diameter_mm,
            self.hole_diameter_mm,
        )
        if own is not None and not shank < own <= hole:
            yield (
                ("washer", "hole_diameter_mm"),
                f"must be greater than the shank's diameter of {shank:g} mm, and at most that of "
                f"the hole in the bars of {hole:g} mm",
            )
