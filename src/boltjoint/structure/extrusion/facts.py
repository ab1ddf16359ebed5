"""Washers and materials of assemblies with bolts, as pages state them."""

import math
from typing import Protocol

from boltjoint.config.bolts import MATERIAL_WORDS, BoltDimensions, Material

#: a number, several of one kind, or words
Fact = float | str | tuple[float, ...]


class HasMaterials(Protocol):
    """What has bolts, and materials of bodies, bolts and washers."""

    @property
    def bolts(self) -> BoltDimensions:
        """Dimensions of the bolts."""

    @property
    def material(self) -> Material:
        """Material of the bodies."""

    @property
    def bolt_material(self) -> Material:
        """Material of the bolts."""

    @property
    def washer_material(self) -> Material:
        """Material of the washers."""


def facts_of_bolts(bolts: BoltDimensions) -> dict[str, Fact]:
    """Dimensions of bolts and washers."""
    diameters = (bolts.shank_diameter_mm, bolts.hole_diameter_mm, bolts.head_diameter_mm)
    return {"diameters of shank, hole and head (mm)": diameters, **_washers(bolts)}


def _washers(bolts: BoltDimensions) -> dict[str, Fact]:
    """Dimensions of the washers, where there are any."""
    washer = bolts.washer
    if washer is None:
        return {}
    hole = bolts.narrow_hole_mm or bolts.hole_diameter_mm
    thickness = "thickness of a washer, diameters of its hole and edge (mm)"
    return {
        "washers under": " and ".join(washer.under),
        thickness: (washer.thickness_mm, hole, washer.diameter_mm),
    }


def facts_of_materials(assembly: HasMaterials) -> dict[str, Fact]:
    """Material of the bodies, and of bolts and washers where it is another; strengths."""
    others = {"of the bolts": assembly.bolt_material}
    if assembly.bolts.washer is not None:
        others["of the washers"] = assembly.washer_material
    rows: dict[str, Fact] = {
        words: getattr(assembly.material, key) for key, words in MATERIAL_WORDS.items()
    }
    for part, material in others.items():
        if material != assembly.material:
            for key, words in MATERIAL_WORDS.items():
                quantity, _, unit = words.partition(" (")
                label = f"{quantity} {part}" + (f" ({unit}" if unit else "")
                rows[label] = getattr(material, key)
    given = [
        None if material is None else material.yield_strength_MPa
        for material in (assembly.material, assembly.bolts.material)
    ]
    strengths = assembly.bolts.yield_strengths(assembly.material)
    for part, own, strength in zip(("bodies", "bolts"), given, strengths, strict=True):
        if not math.isnan(strength):
            default = "" if own else ", by default"
            rows[f"yield strength of the {part}{default} (MPa)"] = 1e-6 * strength
    return rows
