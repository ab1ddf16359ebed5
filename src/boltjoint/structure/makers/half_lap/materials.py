"""Materials of the elements of an assembly, by the parts that they belong to."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks

Array = NDArray[np.float64]


class ElementMaterials(NamedTuple):
    """Linear elastic material of each element.

    ``youngs_modulus`` [Pa], ``poissons_ratio`` [-] and ``density`` [kg/m3], shapes (elements,).
    """

    youngs_modulus: Array
    poissons_ratio: Array
    density: Array


def element_materials(assembly: xr.Dataset) -> ElementMaterials:
    """Material of each element of an assembly.

    It is that of its part, in ``part_youngs_modulus``, ``part_poissons_ratio`` and ``part_density``
    (part_number), or else that of the whole assembly, in ``youngs_modulus``, ``poissons_ratio`` and
    ``density``.

    Raises
    ------
    ValueError
        If a variable is missing or not finite, or an element belongs to no part that has a
        material.
    """
    connectivity = checks.index_variable(
        "assembly", assembly, "connectivity", ("element", "corner")
    )
    return ElementMaterials(
        *(_of_elements(assembly, name, len(connectivity)) for name in ElementMaterials._fields)
    )


def _of_elements(assembly: xr.Dataset, name: str, elements: int) -> Array:
    of_parts = f"part_{name}"
    if of_parts not in assembly:
        return np.full(elements, checks.variable("assembly", assembly, name, ()))
    value = checks.variable("assembly", assembly, of_parts, ("part_number",))
    part = checks.index_variable("assembly", assembly, "part", ("element",), count=len(value))
    return value[part]
