"""What pages state of two tubes with flanges and a bolt circle."""

from boltjoint.config.flange import Flange
from boltjoint.structure.extrusion.facts import Fact, facts_of_bolts, facts_of_materials

MEANING = "Two tubes with flanges that a circle of bolts holds together."


def facts_of(described: Flange) -> dict[str, Fact]:
    """Dimensions, bolts and materials, by what they are called."""
    tubes, flange, circle = described.tubes, described.flange, described.bolt_circle
    diameters = tubes.inner_diameter_mm, tubes.outer_diameter_mm
    return {
        "support": "the end of the lower tube" if described.has_support else "none: free",
        "inner and outer diameter of the tubes (mm)": diameters,
        "lengths of the lower and upper tube (mm)": tubes.length_mm,
        "outer diameter of the flanges (mm)": flange.outer_diameter_mm,
        "thicknesses of the lower and upper flange (mm)": flange.thickness_mm,
        "bolts": described.bolt_count,
        "diameter of the bolt circle (mm)": circle.diameter_mm,
        "angle of the first bolt from x (°)": circle.first_angle_deg,
        **facts_of_bolts(described.bolts),
        **facts_of_materials(described),
        "points": ", ".join(described.input_names) or "none",
    }
