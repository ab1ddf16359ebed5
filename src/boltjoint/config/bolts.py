"""Bolts and washers of an assembly, their materials, and the contact while they are tightened."""

import math
from typing import Annotated, Literal, NamedTuple, Protocol

from pydantic import Field

from boltjoint.config.entries import Entry, EntryWithLaterKeys
from boltjoint.config.types import (
    INTEGRAL,
    NotNegative,
    Number,
    Positive,
    Problems,
    Several,
)

#: what the keys of a material are called
MATERIAL_WORDS = {
    "youngs_modulus_GPa": "Young's modulus (GPa)",
    "poissons_ratio": "Poisson's ratio",
    "density_kg_per_m3": "density (kg/m³)",
}


#: yield strengths of structural steel S355 (EN 10025-2) and of bolts of class 8.8 (ISO 898-1), MPa
S355, CLASS_8_8 = 355.0, 640.0
#: Young's moduli of steels, GPa
_STEEL = 180.0, 220.0


def yield_strength(given: float | None, youngs_modulus: float, of_steel: float = S355) -> float:
    """Yield strength [Pa] as given [MPa], or that of a steel where the material is one.

    Parameters
    ----------
    given
        Yield strength [MPa]; None where it is not given.
    youngs_modulus
        Young's modulus [GPa], which tells steel from others.
    of_steel
        Yield strength of the steel [MPa].

    Returns
    -------
    float
        Not a number of other materials without a strength.
    """
    lowest, highest = _STEEL
    of_material = of_steel if lowest <= youngs_modulus <= highest else math.nan
    return 1e6 * (of_material if given is None else given)


class Material(EntryWithLaterKeys):
    """Linear elastic material."""

    LATER_KEYS = frozenset({"yield_strength_MPa"})

    youngs_modulus_GPa: Positive
    """Young's modulus."""
    poissons_ratio: Annotated[Number, Field(ge=0, lt=0.5)]
    """Poisson's ratio."""
    density_kg_per_m3: Positive
    """Mass density."""
    yield_strength_MPa: Positive | None = None
    """Yield strength, over which the stress at peaks is told, and beyond which a preload gives a
    warning. By default that of steel, where the material is one: 355 MPa, of S355, and 640 MPa of
    bolts, of class 8.8."""


class Washer(EntryWithLaterKeys):
    """Equal washers of all bolts, tied to the bodies, and to head or nut."""

    LATER_KEYS = frozenset({"hole_diameter_mm", "material"})

    thickness_mm: Positive
    """Thickness of a washer; the shanks are longer by that of their washers."""
    diameter_mm: Positive
    """Outer diameter: at least that of the head, less than both sides of a bolt cell, one of which
    may be the width of the bar."""
    hole_diameter_mm: Positive | None = None
    """Diameter of the washer's hole, greater than that of the shank and at most that of the hole in
    the bodies, which it is by default."""
    under: Several[Literal["head", "nut"]] = ("head", "nut")
    """Where washers lie."""
    material: Material | None = None
    """Linear elastic material of the washers; by default that of the bolts."""


class Shank(NamedTuple):
    """Cross-section [m2], Young's modulus and yield strength [Pa] of a shank.

    The strength is None where it is neither given nor that of steel.
    """

    section: float
    youngs_modulus: float
    yield_strength: float | None = None


class BoltDimensions(EntryWithLaterKeys):
    """Dimensions of equal bolts."""

    LATER_KEYS = frozenset({"material", "washer"})

    shank_diameter_mm: Positive
    """Diameter of the shank."""
    hole_diameter_mm: Positive
    """Diameter of the clearance hole, greater than that of the shank."""
    head_diameter_mm: Positive
    """Outer diameter of head and nut, both modelled round: greater than that of the hole, less than
    both sides of a bolt cell, one of which may be the width of the bar."""
    head_height_mm: Positive
    """Height of the head."""
    nut_height_mm: Positive
    """Height of the nut."""
    material: Material | None = None
    """Linear elastic material of the bolts; by default that of the assembly."""
    washer: Washer | None = None
    """Washers under heads and nuts; none by default."""

    @property
    def narrow_hole_mm(self) -> float | None:
        """Diameter of the hole of washers that is narrower than that in the bodies, if any."""
        own = None if self.washer is None else self.washer.hole_diameter_mm
        # to a nanometre: less is a rounding error
        return own if own is not None and round(self.hole_diameter_mm - own, 6) > 0 else None

    @property
    def has_narrow_washers(self) -> bool:
        """Whether there are washers with a hole narrower than that in the bodies."""
        return self.narrow_hole_mm is not None

    @property
    def seat_diameter_mm(self) -> float:
        """Outer diameter of what is tied to the bodies: of the washers, or of the heads."""
        return self.head_diameter_mm if self.washer is None else self.washer.diameter_mm

    @property
    def has_wide_washers(self) -> bool:
        """Whether there are washers that reach beyond the heads."""
        return round(self.seat_diameter_mm - self.head_diameter_mm, 6) > 0

    def conflicts(self) -> Problems:
        for outer, inner in (("hole", "shank"), ("head", "hole")):
            least = getattr(self, f"{inner}_diameter_mm")
            if getattr(self, key := f"{outer}_diameter_mm") <= least:
                yield (key,), f"must be greater than the {inner}'s diameter of {least:g} mm"
        yield from self._conflicts_of_washer()

    def yield_strengths(self, bodies: Material) -> tuple[float, float]:
        """Yield strengths of the bodies and of the bolts [Pa], as of ``yield_strength``."""
        own = None if self.material is None else self.material.yield_strength_MPa
        modulus = self.material_in(bodies).youngs_modulus_GPa
        return (
            yield_strength(bodies.yield_strength_MPa, bodies.youngs_modulus_GPa),
            yield_strength(own, modulus, CLASS_8_8),
        )

    def shank_in(self, bodies: Material) -> Shank:
        """The shank of each bolt."""
        _, strength = self.yield_strengths(bodies)
        return Shank(
            math.pi / 4 * (1e-3 * self.shank_diameter_mm) ** 2,
            1e9 * self.material_in(bodies).youngs_modulus_GPa,
            None if math.isnan(strength) else strength,
        )

    @property
    def hole_clearance_mm(self) -> float:
        """Diameter of the holes less that of the shanks."""
        return self.hole_diameter_mm - self.shank_diameter_mm

    def material_in(self, bodies: Material) -> Material:
        """Material of the bolts, that of the bodies where they have none of their own."""
        return self.material or bodies

    def material_of_washers_in(self, bodies: Material) -> Material:
        """Material of the washers, that of the bolts where they have none of their own."""
        own = None if self.washer is None else self.washer.material
        return own or self.material_in(bodies)

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
                f"the hole in the bodies of {hole:g} mm",
            )


class RowOfBolts(Entry):
    """Places of bolts on the centre line of the lap."""

    positions_from_lap_start_mm: Annotated[tuple[Positive, ...], Field(min_length=1)] | None = None
    """Bolt axes, ascending, measured along the bar from the end of the lap that is nearer to the
    support. The bolt cells lie inside the lap and apart from each other. Or give ``number`` and
    ``pitch_mm``."""
    number: Annotated[int, Field(strict=True, ge=1, le=1000), INTEGRAL] | None = None
    """Number of bolts, in place of their positions: they are centred in the lap."""
    pitch_mm: Positive | None = None
    """Distance between the axes of two bolts, with ``number``; of one bolt there is none."""

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


class Bolts(BoltDimensions, RowOfBolts):
    """Row of equal bolts on the centre line of the lap."""

    def conflicts(self) -> Problems:
        yield from RowOfBolts.conflicts(self)
        yield from BoltDimensions.conflicts(self)


class BoltMesh(Protocol):
    """Divisions of bolts that all meshes have."""

    @property
    def rings_in_shank(self) -> int:
        """Rings of elements in the shank of a bolt."""

    @property
    def rings_under_head(self) -> int:
        """Rings of elements between the edges of hole and head."""

    @property
    def rings_head_to_cell_edge(self) -> int:
        """Rings of elements between the edges of head and cell."""

    @property
    def layers_in_head(self) -> int:
        """Elements through the height of a head, and of a nut."""


class BoltSize(NamedTuple):
    """Nodes of a bolt that the plates do not have, and its elements."""

    nodes: int
    elements: int


def bolt_size(
    bolts: BoltDimensions,
    mesh: BoltMesh,
    sides: tuple[int, int],
    layers_of_plates: int,
    rings_of_rim: int,
    layers_of_washer: int,
) -> BoltSize:
    """Size of a bolt with its washers.

    Parameters
    ----------
    bolts, mesh
        Dimensions and divisions.
    sides
        Elements along both sides of its cell.
    layers_of_plates
        Elements along the shank, in both plates together.
    rings_of_rim
        Rings of elements under a washer beyond the head.
    layers_of_washer
        Elements through the thickness of a washer; 0 without any.
    """
    across, along = sides
    around = 2 * (across + along)
    shank_points = (across + 1) * (along + 1) + mesh.rings_in_shank * around
    # a ring more where the hole of the washers is narrower than that of the plates
    over_hole = int(bolts.has_narrow_washers)
    head_points = shank_points + (mesh.rings_under_head + 1 + over_hole) * around
    shank_quads = across * along + mesh.rings_in_shank * around
    head_quads = shank_quads + (mesh.rings_under_head + 1 + over_hole) * around
    in_heads = 2 * mesh.layers_in_head
    washer_quads = (mesh.rings_under_head + rings_of_rim + over_hole) * around
    washers = 0 if bolts.washer is None else len(bolts.washer.under)
    in_washers = washers * layers_of_washer
    # nodes are shared where a head meets its shank and its plate, and a washer both; of a ring over
    # the hole one side is tied to nothing
    shank_nodes = shank_points * (layers_of_plates + 2 + in_washers)
    head_nodes = in_heads * head_points + 2 * over_hole * around
    washer_nodes = in_washers * (washer_quads + around)
    return BoltSize(
        shank_nodes + head_nodes + washer_nodes,
        (layers_of_plates + in_washers) * shank_quads
        + in_heads * head_quads
        + in_washers * washer_quads,
    )


def rings_of_rim(bolts: BoltDimensions, mesh: BoltMesh, cell_mm: float) -> int:
    """Rings under washers beyond the heads, 0 where washers are not wider.

    By the washer's share of the way from the head to the nearest edge of the cell, which is as
    wide as ``cell_mm``.
    """
    if not bolts.has_wide_washers:
        return 0
    head, rings = bolts.head_diameter_mm, mesh.rings_head_to_cell_edge
    share = min(max((bolts.seat_diameter_mm - head) / max(cell_mm - head, 1e-6), 0.0), 1.0)
    return max(1, min(round(share * rings), rings - 1))


def layers_of_washer(bolts: BoltDimensions, mesh: BoltMesh) -> float:
    """Elements through the thickness of a washer, about as thick as those of a head; 0 without."""
    if bolts.washer is None:
        return 0
    # whole, but no int: the quotient of what is allowed may be infinite
    as_head = bolts.washer.thickness_mm * mesh.layers_in_head / bolts.head_height_mm
    return max(1.0, round(as_head, 0))


class TighteningContact(Entry):
    """Contact between two bodies during tightening of the bolts."""

    penalty_N_per_m3: Positive = 1e15
    """Normal contact stiffness for each unit of area."""
    friction_coefficient: NotNegative = 0.1
    """Coulomb friction during tightening."""
