"""Modes and contact of an assembly from the printed output of CalculiX."""

import re
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.dataset import quantity
from boltjoint.structure.hexahedron import HEXAHEDRON_FACES
from boltjoint.structure.makers.half_lap.calculix.decks import faces_among_nodes

Array = NDArray[np.float64]

#: where Fortran leaves out the E, before an exponent of three digits
_LEFT_OUT = re.compile(r"(?<=\d)(?=[+-]\d{3})")


def read_modes(assembly: xr.Dataset, path: str | Path) -> xr.Dataset:
    """Modes that CalculiX printed.

    Parameters
    ----------
    assembly
        The assembly that the deck was written from.
    path
        The file ending in ``.dat``.

    Returns
    -------
    Dataset
        ``natural_frequency`` (mode) [Hz] and ``mode_shape`` (node, axis, mode) [kg^-1/2], as in
        ``modes.nc``.

    Raises
    ------
    ValueError
        If the file does not hold them.
    """
    paragraphs = _paragraphs(path)
    (table,) = _after("CYCLES/TIME", paragraphs, path)
    shapes = [_of_nodes(assembly, printed) for printed in _after("set ALL", paragraphs, path)]
    # the nodes across a closed section were one node
    nut_side, head_side = assembly["section_node"].to_numpy().T
    shape = np.stack(shapes, axis=-1)
    shape[head_side] = shape[nut_side]
    return xr.Dataset(
        {
            "natural_frequency": quantity("mode", table[:, 3], "Hz", "natural frequency"),
            "mode_shape": quantity(
                ("node", "axis", "mode"), shape, "kg^-1/2", "mass-normalised mode"
            ),
        },
        coords={"axis": assembly["axis"].variable},
    )


def read_preload(assembly: xr.Dataset, path: str | Path) -> xr.Dataset:
    """Contact under preload that CalculiX printed.

    Parameters
    ----------
    assembly
        The assembly that the deck was written from.
    path
        The file ending in ``.dat``.

    Returns
    -------
    Dataset
        ``normal_load`` (pair) [N], ``friction_force`` (pair, plane) [N], ``gap`` (pair) [m] and
        ``shank_shortening`` (bolt) [m], as in ``preload.nc``, but for the small tension of open
        pairs, whose normal load is negative.

    Raises
    ------
    ValueError
        If the file does not hold them.
    """
    paragraphs = _paragraphs(path)
    (on_a,) = _after("set SIDE_A", paragraphs, path)
    (on_b,) = _after("set SIDE_B", paragraphs, path)
    (bolts,) = _after("set TIGHTENING", paragraphs, path)
    (stress,) = _after("contact stress", paragraphs, path)

    side_a, side_b = assembly["pair_node"].to_numpy().T
    opening = _of_nodes(assembly, on_b)[side_b, 2] - _of_nodes(assembly, on_a)[side_a, 2]
    force = _of_nodes(assembly, stress)[side_a] * _slave_area(assembly)[:, None]
    # tangents of a face with a downward normal: the first along x, the second along -y
    friction = force[:, 1:] * [1, -1]
    return xr.Dataset(
        {
            "normal_load": quantity("pair", force[:, 0], "N", "normal load of the contact pair"),
            "friction_force": quantity(
                ("pair", "plane"), friction, "N", "friction force on side B"
            ),
            "gap": quantity("pair", np.maximum(opening, 0.0), "m", "opening"),
            "shank_shortening": quantity(
                "bolt", bolts[:, 1], "m", "shortening of the shank by tightening"
            ),
        },
        coords={"plane": ["x", "y"]},
    )


def _slave_area(assembly: xr.Dataset) -> Array:
    """Area that CalculiX gives to the contact nodes of bar A: a quarter of each face, (pairs,)."""
    side_a = assembly["pair_node"].sel(side="A").to_numpy()
    element, face = faces_among_nodes(assembly, side_a).T
    corners = assembly["connectivity"].to_numpy()[element[:, None], HEXAHEDRON_FACES[face]]
    point = assembly["coordinate"].to_numpy()[corners]
    diagonals = point[:, 2] - point[:, 0], point[:, 3] - point[:, 1]
    quarter = np.linalg.norm(np.cross(*diagonals), axis=1) / 2 / 4
    area = np.bincount(corners.ravel(), np.repeat(quarter, 4), minlength=assembly.sizes["node"])
    return area[side_a]


def _paragraphs(path: str | Path) -> list[list[str]]:
    """Lines of a printed file between empty ones: a table is the paragraph after its title."""
    with Path(path).open(encoding="ascii") as lines:
        return [
            list(group) for filled, group in groupby(lines, lambda x: not x.isspace()) if filled
        ]


def _after(title: str, paragraphs: list[list[str]], path: str | Path) -> list[Array]:
    """The tables after the paragraphs whose last line holds a title."""
    tables = [
        np.array([_LEFT_OUT.sub("E", line).split() for line in table], dtype=float)
        for head, table in pairwise(paragraphs)
        if title in head[-1]
    ]
    if not tables:
        raise ValueError(f"{path}: CalculiX printed no {title!r}")
    return tables


def _of_nodes(assembly: xr.Dataset, printed: Array) -> Array:
    """Three values of each node from lines of label and values, (nodes, 3); 0 where none are."""
    values = np.zeros((assembly.sizes["node"], 3))
    values[printed[:, 0].astype(int) - 1] = printed[:, 1:]
    return values
