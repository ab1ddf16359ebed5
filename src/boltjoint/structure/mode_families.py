"""Families of modes of vibration: bending, axial, lateral and torsional, by kinetic energy."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse

from boltjoint import checks
from boltjoint.structure.half_lap.mesh import FIRST_BOLT

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Modes:
    """Modes of vibration and their families.

    ``frequency`` (modes,) [Hz]; ``shape`` (nodes, 3, modes) [kg^-1/2], mass-normalised;
    ``energy_share`` (modes, 3): kinetic energy along x, y, z over all of it; ``symmetric_share``
    (modes,): see ``symmetric_share``; ``family`` (modes,): see ``classify``.
    """

    frequency: Array
    shape: Array
    energy_share: Array
    symmetric_share: Array
    family: NDArray[np.str_]


def classify_modes(
    assembly: xr.Dataset, M: sparse.csc_array, frequency: Array, shape: Array
) -> Modes:
    """Modes of an assembly with their families.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
    M
        Its mass matrix, from ``assemble_assembly`` [kg].
    frequency, shape
        As in ``Modes``.
    """
    moved = (M @ shape.reshape(-1, len(frequency))).reshape(shape.shape)
    energy_share = np.einsum("nam,nam->ma", shape, moved)
    energy_share /= energy_share.sum(axis=1, keepdims=True)
    lumped = np.asarray(M.sum(axis=0)).reshape(-1, 3)[:, 0]
    symmetric = symmetric_share(assembly["coordinate"].to_numpy(), lumped, shape)
    of_bars = np.unique(assembly["connectivity"].to_numpy()[assembly["part"] < FIRST_BOLT])
    _, width, height = np.ptp(assembly["coordinate"].to_numpy()[of_bars], axis=0)
    return Modes(
        frequency, shape, energy_share, symmetric, classify(energy_share, symmetric, width, height)
    )


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
        Of the cross-section [m].

    Returns
    -------
    ndarray
        The words ``bending``, ``axial``, ``lateral``, ``torsional``, shape (modes,).

    Raises
    ------
    ValueError
        If shapes do not fit each other, a share is not from 0 to 1, or a side is not positive.
    """
    share = {"at_least": 0, "at_most": 1 + 1e-9}  # but for rounding
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
