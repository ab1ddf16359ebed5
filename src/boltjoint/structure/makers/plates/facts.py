"""What pages state of two plates with a pattern of bolts."""

from boltjoint.config.plates import Plates
from boltjoint.structure.extrusion.facts import Fact, facts_of_bolts, facts_of_materials

MEANING = "Two plates that overlap, held together by a pattern of bolts: a single-lap shear joint."


def facts_of(described: Plates) -> dict[str, Fact]:
    """Dimensions, bolts and materials, by what they are called."""
    plates, pattern = described.plates, described.pattern
    held = "the end of the lower plate" if described.has_support else "none: free"
    places = "; ".join(f"{x:g}, {y:g}" for x, y in pattern.positions_mm)
    return {
        "support": held,
        "width of the plates (mm)": plates.width_mm,
        "thicknesses of the lower and upper plate (mm)": plates.thickness_mm,
        "held end to lap (mm)": plates.free_length_mm[0],
        "lap (mm)": plates.lap_mm,
        "lap to free end (mm)": plates.free_length_mm[1],
        "bolts": described.bolt_count,
        "bolts, x and y from the middle of the lap (mm)": places,
        **facts_of_bolts(described.bolts),
        **facts_of_materials(described),
        "points": ", ".join(described.input_names) or "none",
    }
