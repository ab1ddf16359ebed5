"""Structures as files: ``structure.nc``."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from boltjoint import checks, dataset
from boltjoint.dataset import quantity
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.factors import AUTO
from boltjoint.structure.geometry import CellMaterial, Geometry
from boltjoint.structure.model import Bolt, Reflection, Row, Structure, mirrored

#: a mesh repeats its elements, and so the entries of its matrices: a fifth of the bytes
_COMPRESSED = {"zlib": True, "complevel": 1, "shuffle": True}

#: variables of the contact points: dimensions after the point, unit, meaning
_OF_POINTS = {
    "position": (("axis",), "m", "position of the contact point"),
    "frame": (("direction", "axis"), "1", "two tangents and the normal"),
    "area": ((), "m2", "tributary area of the contact point"),
    "gap": ((), "m", "initial gap"),
    "penalty": ((), "N/m3", "static contact stiffness per area"),
    "friction_coefficient": ((), "1", "Coulomb friction while bolts are tightened"),
}


def save_structure(
    structure: Structure, path: str | Path, parameters: Mapping[str, object] | None = None
) -> None:
    """Write a structure as ``structure.nc``, as ``dataset.save`` does."""
    dataset.save(structure_to_dataset(structure), path, parameters)


def load_structure(path: str | Path) -> Structure:
    """Read what ``save_structure`` has written.

    Raises
    ------
    FileNotFoundError, DamagedFile
        As for ``dataset.load``.
    """
    return structure_from_dataset(dataset.load(path))


def structure_to_dataset(structure: Structure) -> xr.Dataset:
    """A structure as ``structure.nc`` holds it.

    Of ``stiffness`` and ``mass`` the upper triangle, of these, ``relative`` and ``displacement``
    columns one after another: ``<name>_entry``, the row of each, ``<name>_row``, and the first
    entry of each column, ``<name>_start``.
    """
    checks.instance("structure", structure, Structure)
    contact, geometry, mirror = structure.contact, structure.geometry, structure.symmetry
    variables = {
        **_columns("stiffness", sparse.triu(structure.stiffness, format="csc"), "N/m"),
        **_columns("mass", sparse.triu(structure.mass, format="csc"), "kg"),
        **_columns("relative", contact.relative.tocsc(), "1"),
        "surface": xr.Variable("point", contact.surface.astype(object), {"units": "1"}),
        **_of_bolts(structure),
        **_of_rows("input", structure.inputs, structure.dofs),
        **_of_rows("output", structure.outputs, structure.dofs),
        "rigid": _compressed(("dof", "motion"), structure.rigid, "1", "rigid-body motions"),
    }
    for name, (dims, unit, meaning) in _OF_POINTS.items():
        variables[name] = quantity(("point", *dims), getattr(contact, name), unit, meaning)
    if contact.normal_load is not None:
        meaning = "normal load under preload, as given"
        variables["normal_load"] = quantity("point", contact.normal_load, "N", meaning)
    if structure.support is not None:
        meaning = "force of a unit acceleration of the supports"
        variables["support"] = _compressed(("axis", "dof"), structure.support, "kg", meaning)
    if structure.base_springs is not None:
        meaning = "normal springs of closed points in modes and bases"
        variables["base_springs"] = quantity("point", structure.base_springs, "N/m", meaning)
    if mirror is not None:
        variables |= {
            "mirror_dof": _compressed("dof", mirror.image, "1", "mirror image of the dof"),
            "mirror_sign": _compressed("dof", mirror.sign, "1", "and its sign"),
            "mirror_point": quantity("point", mirror.point, "1", "mirror image of the point"),
        }
    if geometry is not None:
        variables |= {
            **_columns("displacement", geometry.displacement, "1"),
            "node": _compressed(("node_number", "axis"), geometry.node, "m", "position"),
            "cell": _compressed(("cell_number", "corner"), geometry.cell, "1", "nodes of the cell"),
            "part": _compressed("cell_number", geometry.part, "1", "part of the cell"),
            **_of_cells(geometry.material),
        }
    return xr.Dataset(
        variables,
        coords={"axis": ["x", "y", "z"], "direction": ["t1", "t2", "n"]},
        attrs={"maker": structure.maker, **_factorisation(structure)},
    )


def contact_to_dataset(structure: Structure) -> xr.Dataset:
    """A structure without a mesh of its maker, as ``assembly.nc`` holds it.

    ``position``, ``area`` and ``frame`` of the contact points (pair), and where the geometry is
    known its ``coordinate`` (node, axis) [m], ``connectivity`` (element, corner) and ``part``.
    """
    geometry, variables = structure.geometry, structure.contact.variables()
    if geometry is not None:
        variables |= {
            "coordinate": quantity(("node", "axis"), geometry.node, "m", "position of the node"),
            "connectivity": quantity(
                ("element", "corner"), geometry.cell, "1", "nodes of the element, order of VTK"
            ),
            "part": quantity("element", geometry.part, "1", "part of the element"),
        }
    coordinates = {"axis": ["x", "y", "z"]}
    attributes = {"maker": structure.maker, "degrees_of_freedom": structure.dofs}
    return xr.Dataset(variables, coords=coordinates, attrs=attributes)


def structure_from_dataset(stored: xr.Dataset) -> Structure:
    """The structure that ``structure_to_dataset`` has stored.

    Raises
    ------
    ValueError
        If a variable is missing, or as for ``Structure``.
    """
    checks.instance("structure", stored, xr.Dataset)
    upper = {name: _matrix(stored, name) for name in ("stiffness", "mass")}
    whole = {name: mirrored(triangle) for name, triangle in upper.items()}
    dofs = whole["stiffness"].shape[0]
    of_points = [*_OF_POINTS, *(["normal_load"] if "normal_load" in stored else [])]
    points = {name: stored[name].to_numpy() for name in of_points}
    relative = _matrix(stored, "relative", 3 * len(points["area"])).tocsr()
    surface = stored["surface"].to_numpy().astype(str)
    symmetry = geometry = None
    if "mirror_dof" in stored:
        names = ("mirror_dof", "mirror_sign", "mirror_point")
        symmetry = Reflection(*(stored[name].to_numpy() for name in names))
    if "node" in stored:
        node, cell, part = (stored[name].to_numpy() for name in ("node", "cell", "part"))
        displacement = _matrix(stored, "displacement", 3 * len(node))
        geometry = Geometry(node, displacement, cell, part, _material(stored))
    return Structure(
        **whole,
        contact=ContactPoints(relative=relative, surface=surface, **points),
        bolts=_bolts(stored),
        inputs=_rows(stored, "input"),
        outputs=_rows(stored, "output"),
        support=stored["support"].to_numpy() if "support" in stored else None,
        rigid=stored["rigid"].to_numpy().reshape(dofs, -1),
        symmetry=symmetry,
        geometry=geometry,
        maker=stored.attrs["maker"],
        factorisation=stored.attrs.get("factorisation", AUTO),
        base_springs=stored["base_springs"].to_numpy() if "base_springs" in stored else None,
    )


#: of the material of the cells: unit and meaning
_OF_CELLS = {
    "youngs_modulus": ("Pa", "Young's modulus of the cell"),
    "poissons_ratio": ("1", "Poisson's ratio of the cell"),
    "yield_strength": ("Pa", "yield strength of the cell"),
}


def _of_cells(material: CellMaterial | None) -> dict[str, xr.Variable]:
    if material is None:
        return {}
    return {
        f"cell_{name}": _compressed("cell_number", getattr(material, name), unit, meaning)
        for name, (unit, meaning) in _OF_CELLS.items()
    }


def _material(stored: xr.Dataset) -> CellMaterial | None:
    names = [f"cell_{name}" for name in _OF_CELLS]
    return CellMaterial(*(stored[n].to_numpy() for n in names)) if names[0] in stored else None


def _factorisation(structure: Structure) -> dict[str, str]:
    """The method of the factors, also the one that is chosen where it takes a package."""
    is_default = structure.factorisation == AUTO and structure.symmetry is not None
    return {} if is_default else {"factorisation": structure.factor_method}


def _compressed(dims: str | tuple[str, ...], values: object, unit: str, what: str) -> xr.Variable:
    variable = quantity(dims, values, unit, what)
    variable.encoding = dict(_COMPRESSED)
    return variable


def _columns(name: str, matrix: sparse.csc_array, unit: str) -> dict[str, xr.Variable]:
    entry, column = f"{name}_number", f"{name}_column"
    return {
        f"{name}_entry": _compressed(entry, matrix.data, unit, f"entries of {name}"),
        f"{name}_row": _compressed(entry, matrix.indices, "1", "row of the entry"),
        f"{name}_start": _compressed(column, matrix.indptr, "1", "first entry of the column"),
    }


def _matrix(stored: xr.Dataset, name: str, rows: int | None = None) -> sparse.csc_array:
    entry, row, start = (stored[f"{name}_{part}"].to_numpy() for part in ("entry", "row", "start"))
    columns = start.size - 1
    shape = columns if rows is None else rows, columns
    return sparse.csc_array((entry, row, start), shape=shape)


def _of_bolts(structure: Structure) -> dict[str, xr.Variable]:
    def each(name: str, missing: ArrayLike) -> NDArray:
        values = [getattr(bolt, name) for bolt in structure.bolts]
        complete = [missing if value is None else value for value in values]
        return np.array(complete).reshape(len(complete), *np.shape(missing))

    nowhere, load = np.full(3, np.nan), np.zeros((structure.dofs, len(structure.bolts)))
    for place, bolt in enumerate(structure.bolts):
        load[:, place] = bolt.load
    axes = ("bolt", "axis")
    return {
        "bolt_name": xr.Variable("bolt", np.array([bolt.name for bolt in structure.bolts], object)),
        "bolt_load": _compressed(("dof", "bolt"), load, "1", "forces of a tension of 1 N"),
        "bolt_locked": quantity("bolt", each("locked", -1), "1", "dof held after tightening"),
        "bolt_axis": quantity(axes, each("axis", nowhere), "1", "direction"),
        "bolt_position": quantity(axes, each("position", nowhere), "m", "point on the axis"),
        "bolt_section": quantity("bolt", each("section", np.nan), "m2", "of the shank"),
        "bolt_modulus": quantity("bolt", each("youngs_modulus", np.nan), "Pa", "of the shank"),
        "bolt_strength": quantity("bolt", each("yield_strength", np.nan), "Pa", "of the shank"),
        "bolt_clearance": quantity("bolt", each("hole_clearance", np.nan), "m", "in its hole"),
    }


_OF_SHANK = ("section", "modulus", "strength", "clearance")


def _bolts(stored: xr.Dataset) -> tuple[Bolt, ...]:
    def known(name: str, place: int) -> NDArray | None:
        if f"bolt_{name}" not in stored:
            return None
        value = stored[f"bolt_{name}"].to_numpy()[place]
        return None if np.any(np.isnan(value)) else value

    bolts = []
    for place, name in enumerate(stored["bolt_name"].to_numpy()):
        locked = int(stored["bolt_locked"].to_numpy()[place])
        numbers = [known(key, place) for key in _OF_SHANK]
        section, modulus, strength, clearance = (None if x is None else float(x) for x in numbers)
        bolts.append(
            Bolt(
                name=str(name),
                load=stored["bolt_load"].transpose("dof", "bolt").to_numpy()[:, place],
                locked=None if locked < 0 else locked,
                axis=known("axis", place),
                position=known("position", place),
                section=section,
                youngs_modulus=modulus,
                yield_strength=strength,
                hole_clearance=clearance,
            )
        )
    return tuple(bolts)


def _of_rows(what: str, rows: Mapping[str, Row], dofs: int) -> dict[str, xr.Variable]:
    table = np.array([row.row for row in rows.values()]).reshape(len(rows), dofs)
    directions = np.array([row.direction for row in rows.values()], dtype=object)
    return {
        f"{what}_name": xr.Variable(what, np.array(list(rows), dtype=object)),
        f"{what}_row": _compressed((what, "dof"), table, "1", f"displacement of the {what}"),
        f"{what}_direction": xr.Variable(what, directions),
    }


def _rows(stored: xr.Dataset, what: str) -> dict[str, Row]:
    names, rows, directions = (
        stored[f"{what}_{part}"].to_numpy() for part in ("name", "row", "direction")
    )
    return {
        str(name): Row(row, str(direction))
        for name, row, direction in zip(names, rows, directions, strict=True)
    }
