"""Dimensions and materials of a half lap, as pages state them."""

from boltjoint.config.assembly import Assembly
from boltjoint.config.bolts import MATERIAL_WORDS, Bolts

MEANING = (
    "Two bars, each cut to half its height over the lap, clamped at one end and held by a row of "
    "bolts."
)

#: a number, several of one kind, or words
Fact = float | str | tuple[float, ...]


def facts_of(assembly: Assembly) -> dict[str, Fact]:
    """What is told of an assembly, by what it is called."""
    bar, bolts = assembly.bar, assembly.bolts
    diameters = (bolts.shank_diameter_mm, bolts.hole_diameter_mm, bolts.head_diameter_mm)
    support = {} if assembly.has_support else {"support": "none: free at both ends"}
    return {
        **support,
        "width of the bars (mm)": bar.width_mm,
        "height outside the lap (mm)": bar.height_mm,
        "clamp to lap (mm)": bar.free_length_mm[0],
        "lap (mm)": bar.lap_mm,
        "lap to free end (mm)": bar.free_length_mm[1],
        "bolts": assembly.bolt_count,
        "bolts, from the start of the lap (mm)": assembly.bolt_positions_mm,
        "diameters of shank, hole and head (mm)": diameters,
        **_washers(bolts),
        **_materials(assembly),
    }


def _washers(bolts: Bolts) -> dict[str, Fact]:
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


def _materials(assembly: Assembly) -> dict[str, Fact]:
    """Material of the bars, and of bolts and washers where it is another."""
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
    return rows
