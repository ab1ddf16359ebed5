"""Families of modes of vibration: bending, axial, lateral and torsional, by kinetic energy."""

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.structure.geometry import Geometry
from boltjoint.structure.makers.half_lap.parts import FIRST_BOLT
from boltjoint.structure.makers.registry import Families
from boltjoint.structure.model import Structure

Array = NDArray[np.float64]


def families_of(structure: Structure, q: Array) -> Families:
    """Families of modes of a half lap.

    Parameters
    ----------
    structure
        As from ``structure_of``.
    q
        The modes, shape (dofs, modes).
    """
    geometry = checks.instance("geometry of the structure", structure.geometry, Geometry)
    # neither mass nor constraints mix the axes
    axis = geometry.displacement.indices[geometry.displacement.indptr[:-1]] % 3
    energy = q * (structure.mass @ q)
    energy_share = np.stack(
        [energy[axis == direction].sum(axis=0) for direction in range(3)], axis=1
    )
    energy_share /= energy_share.sum(axis=1, keepdims=True)
    along_x = geometry.displacement[::3]
    lumped = along_x @ np.asarray(structure.mass.sum(axis=0)).ravel()
    symmetric = symmetric_share(geometry.node, lumped, geometry.shape(q))
    of_bars = np.unique(geometry.cell[geometry.part < FIRST_BOLT])
    _, width, height = np.ptp(geometry.node[of_bars], axis=0)
    family = classify(energy_share, symmetric, width, height)
    return Families(family, energy_share, symmetric)


def classify(
    energy_share: Array, symmetric_share: Array, width: float, height: float
) -> NDArray[np.str_]:
    """Classify bending, axial, lateral and torsional modes of a bar.

    Symmetric about the width: bending where more than half of the kinetic energy is along z, else
    axial. Antisymmetric: the energy along z is all from twisting. A rigidly twisting rectangle has
    energies along y and z as height^2 to width^2, so the twist has 1 + (height / width)^2 times the
    energy along z: torsional where that is more than half of all, else lateral.

    Parameters
    ----------
    energy_share
        Kinetic energy along x, y, z over all of it, shape (modes, 3).
    symmetric_share
        1 for a symmetric mode, 0 for an antisymmetric one, shape (modes,).
    width, height
        Width and height of the cross-section [m].

    Returns
    -------
    ndarray
        The words ``bending``, ``axial``, ``lateral``, ``torsional``, shape (modes,).

    Raises
    ------
    ValueError
        If shapes do not fit each other, a share is not from 0 to 1, or a side is not positive.
    """
    share = checks.Limits(at_least=0, at_most=1 + 1e-9)  # but for rounding
    energy_share = checks.array("energy_share", energy_share, ("modes", 3), **share)
    symmetric_share = checks.array(
        "symmetric_share", symmetric_share, energy_share.shape[:1], **share
    )
    width = checks.number("width", width, above=0)
    height = checks.number("height", height, above=0)
    along_z = energy_share[:, 2]
    twist = along_z * (1 + (height / width) ** 2)
    symmetric = np.where(along_z > 0.5, "bending", "axial")
    antisymmetric = np.where(twist > 0.5, "torsional", "lateral")
    return np.where(symmetric_share > 0.5, symmetric, antisymmetric)


def symmetric_share(coordinate: Array, mass: Array, shape: Array) -> Array:
    """Share of the middle plane's kinetic energy that belongs to motion symmetric about it.

    On y = 0 a symmetric mode moves along x and z only, an antisymmetric one along y only.

    Parameters
    ----------
    coordinate
        Nodes, shape (nodes, 3) [m].
    mass
        Lumped mass of the nodes, shape (nodes,) [kg].
    shape
        Modes, shape (nodes, 3, modes).

    Returns
    -------
    ndarray
        Between 0 and 1, shape (modes,).

    Raises
    ------
    ValueError
        If no nodes lie on y = 0, or shapes do not fit each other.
    """
    coordinate = checks.array("coordinate", coordinate, ("nodes", 3))
    mass = checks.array("mass", mass, coordinate.shape[:1], at_least=0)
    shape = checks.array("shape", shape, (*coordinate.shape, "modes"))
    y = coordinate[:, 1]
    on_plane = abs(y) < 1e-9 * np.ptp(y)
    if not on_plane.any():
        raise ValueError("no nodes lie on the middle plane y = 0")
    energy = np.einsum("n,nam->ma", mass[on_plane], shape[on_plane] ** 2)
    return (energy[:, 0] + energy[:, 2]) / energy.sum(axis=1)
