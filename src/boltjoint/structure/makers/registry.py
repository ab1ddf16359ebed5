"""The makers of structures by name."""

import numpy as np
import xarray as xr

from boltjoint import checks
from boltjoint.structure.families import Families
from boltjoint.structure.makers.half_lap import families as half_lap_families
from boltjoint.structure.makers.half_lap import structure as half_lap
from boltjoint.structure.model import Structure

#: by the name of a maker, how it tells families of modes apart
_FAMILIES = {half_lap.NAME: half_lap_families.families_of}


def structure_of(assembly: xr.Dataset | Structure) -> Structure:
    """A structure, or that of an assembly that a maker has meshed.

    Raises
    ------
    ValueError
        If it is neither, or as for ``structure_of`` of the maker.
    """
    checks.instance("assembly", assembly, xr.Dataset, Structure)
    return assembly if isinstance(assembly, Structure) else half_lap.structure_of(assembly)


def families_of(structure: Structure, q: np.ndarray) -> Families:
    """Families of elastic modes q, shape (dofs, modes)."""
    known = _FAMILIES.get(structure.maker)
    return known(structure, q) if known else Families(np.full(q.shape[1], "elastic"))
