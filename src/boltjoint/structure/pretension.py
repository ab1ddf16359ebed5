"""Pretension of the bolts: the tension of each, cross-section and modulus of their shanks."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from boltjoint import checks
from boltjoint.structure.materials import element_materials


def tension_of(preload: float | Sequence[float], bolts: int) -> NDArray[np.float64]:
    """Tension of each bolt [N], from the preload of all or of each.

    Raises
    ------
    ValueError
        If there is not one for each bolt, one is negative, or all are 0.
    """
    if np.ndim(preload) == 0:
        return np.full(bolts, checks.number("preload", preload, above=0))
    tension = checks.array("preload", preload, (bolts,), at_least=0)
    if not tension.any():
        raise ValueError("preload is 0 for all bolts: one must be tightened")
    return tension


def shank_area(assembly: xr.Dataset) -> float:
    """Cross-section of the first shank [m2], by the nodes of its pretension section."""
    of_first = assembly["section_bolt"].to_numpy() == 0
    node = assembly["section_node"].to_numpy()[of_first, 0]
    # the volume of a hull in the plane is its area
    return float(ConvexHull(assembly["coordinate"].to_numpy()[node, :2]).volume)


def shank_modulus(assembly: xr.Dataset) -> float:
    """Young's modulus of the first shank [Pa]: of the elements at its pretension section."""
    of_first = assembly["section_bolt"].to_numpy() == 0
    in_section = np.zeros(assembly.sizes["node"], dtype=bool)
    in_section[assembly["section_node"].to_numpy()[of_first]] = True
    connectivity = assembly["connectivity"].transpose("element", "corner").to_numpy()
    element = np.flatnonzero(in_section[connectivity].any(axis=1))
    return float(element_materials(assembly).youngs_modulus[element[0]])
