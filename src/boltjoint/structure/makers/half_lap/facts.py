"""Dimensions and materials of a half lap, as pages state them."""

from boltjoint.config.lap_joint import LapJoint
from boltjoint.structure.extrusion.facts import Fact, facts_of_bolts, facts_of_materials

MEANING = (
    "Two bars, each cut to half its height over the lap, clamped at one end and held by a row of "
    "bolts."
)


def facts_of(assembly: LapJoint) -> dict[str, Fact]:
    """What is told of an assembly, by what it is called."""
    bar, bolts = assembly.bar, assembly.bolts
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
        **facts_of_bolts(bolts),
        **facts_of_materials(assembly),
    }
