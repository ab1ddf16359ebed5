"""Parts of a half-lap assembly: their numbers and names, and the materials of their elements."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dataset import quantity

if TYPE_CHECKING:
    from boltjoint.config.lap_joint import LapJoint


#: parts of the assembly; the bolts follow the bars, and the washers of each bolt all bolts
BAR_A, BAR_B, FIRST_BOLT = 0, 1, 2

_GPA = 1e9

#: properties of a material: key, factor to SI, unit and meaning
_PROPERTIES = {
    "youngs_modulus": ("youngs_modulus_GPa", _GPA, "Pa", "Young's modulus"),
    "poissons_ratio": ("poissons_ratio", 1.0, "1", "Poisson's ratio"),
    "density": ("density_kg_per_m3", 1.0, "kg/m3", "density"),
}


def first_washer(bolts: int) -> int:
    """Number of the part of the first bolt's washers, where there are any."""
    return FIRST_BOLT + bolts


def part_kinds(assembly: xr.Dataset) -> list[str]:
    """Kind of each part of an assembly by its number: bar A, bar B, bolts or washers."""
    bolts = assembly.sizes.get("bolt", 0)
    washers = int(assembly["part"].max()) + 1 - first_washer(bolts)
    return ["bar A", "bar B", *["bolts"] * bolts, *["washers"] * max(0, washers)]


def part_variable(assembly: "LapJoint", part: NDArray[np.integer]) -> xr.Variable:
    """Part of each element, with the names of all parts."""
    bolts = range(1, len(assembly.bolt_positions_mm) + 1)
    names = ["bar_A", "bar_B", *(f"bolt_{b}" for b in bolts)]
    if assembly.bolts.washer is not None:
        names += [f"washers_{b}" for b in bolts]
    # with room for a further number, that of the contact surface in views of the mesh
    kind = np.int8 if len(names) <= np.iinfo(np.int8).max else np.int16
    meaning = "part of the assembly the element belongs to"
    variable = quantity("element", part.astype(kind), "1", meaning)
    variable.attrs["flag_values"] = np.arange(len(names), dtype=kind)
    variable.attrs["flag_meanings"] = " ".join(names)
    return variable


def material_variables(assembly: "LapJoint") -> dict[str, xr.Variable]:
    """Material of the bars, and of each part where bolts or washers have another; strengths."""
    bars, bolts, washer = assembly.material, assembly.bolts, assembly.bolts.washer
    count = len(assembly.bolt_positions_mm)
    variables = {
        name: quantity((), factor * getattr(bars, key), unit, meaning)
        for name, (key, factor, unit, meaning) in _PROPERTIES.items()
    }
    of_bars, of_bolts = bolts.yield_strengths(bars)
    strengths = [of_bars] * FIRST_BOLT + [of_bolts] * count
    strengths += [np.nan] * (count if washer is not None else 0)
    meaning = "yield strength of each part, not a number where stresses are not compared with it"
    variables["part_yield_strength"] = quantity("part_number", np.array(strengths), "Pa", meaning)
    if bolts.material is None and (washer is None or washer.material is None):
        return variables
    of_parts = [bars] * FIRST_BOLT + [assembly.bolt_material] * count
    of_parts += [assembly.washer_material] * (count if washer is not None else 0)
    for name, (key, factor, unit, meaning) in _PROPERTIES.items():
        values = [factor * getattr(material, key) for material in of_parts]
        meaning = f"{meaning} of each part"
        variables[f"part_{name}"] = quantity("part_number", values, unit, meaning)
    return variables


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
