"""Half laps: two bars, each cut to half its height, clamped at one end and held by bolts."""

from pathlib import Path
from typing import TYPE_CHECKING

from boltjoint.config.lap_joint import LapJoint as Description

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from boltjoint.structure.makers.registry import Families
    from boltjoint.structure.model import Structure

__all__ = [
    "CALCULIX",
    "DISPLAYS",
    "PAGE",
    "Description",
    "families_of",
    "load_on_surface",
    "loaded_nodes",
    "make",
    "structure_of",
]

#: modules that tell pages of them, and that declare their figures
PAGE = f"{__name__}.facts"
DISPLAYS = f"{__name__}.displays"
#: module that writes decks for CalculiX and compares what it finds
CALCULIX = f"{__name__}.comparison_with_calculix"


def make(description: Description, folder: Path) -> "xr.Dataset":
    """The mesh."""
    from boltjoint.config.gap_map import load_gap_map
    from boltjoint.structure.makers.half_lap import mesh

    file = description.gap_file
    gap_map = None if file is None else load_gap_map(folder / file)
    return mesh.build_assembly(description, gap_map)


def structure_of(assembly: "xr.Dataset") -> "Structure":
    """The structure of a mesh."""
    from boltjoint.structure.makers.half_lap import structure

    return structure.structure_of(assembly)


def families_of(structure: "Structure", q: "np.ndarray") -> "Families":
    """Families of elastic modes q, shape (dofs, modes)."""
    from boltjoint.structure.makers.half_lap import families

    return families.families_of(structure, q)


def loaded_nodes(assembly: "xr.Dataset") -> "np.ndarray":
    """Numbers of the nodes where forces may act and motion may be read."""
    from boltjoint.structure.makers.half_lap import structure

    return structure.nodes_of_bars(assembly)


def load_on_surface(assembly: "xr.Dataset", surface: str) -> "np.ndarray":
    """Nodal forces of an even load of one newton on a surface, shape (nodes,)."""
    from boltjoint.structure.makers.half_lap import structure

    return structure.load_on_surface(assembly, surface)
