"""Halves of an assembly: unknowns of the motion symmetric about the width, and of the other.

Excitation, response and normal load are symmetric, so bending in the plane of the bar needs the
unknowns of symmetric motion only.
"""

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from boltjoint.structure.constraints import ConstrainedStructure, constrain, free_displacements


def symmetric_half(assembly: xr.Dataset) -> ConstrainedStructure:
    """The assembly in unknowns that move both halves of its width symmetrically.

    Raises
    ------
    ValueError
        If the mesh is not symmetric about y = 0.
    """
    return constrain(assembly, symmetric_displacements(assembly, tightened=False))


def antisymmetric_half(assembly: xr.Dataset) -> ConstrainedStructure:
    """The assembly in unknowns that move one half of its width as the negative mirror image.

    Raises
    ------
    ValueError
        If the mesh is not symmetric about y = 0.
    """
    T = free_displacements(assembly, tightened=False)
    return constrain(assembly, (T @ _unknowns_of_half(T, _mirrored_nodes(assembly), -1.0)).tocsc())


def symmetric_displacements(assembly: xr.Dataset, *, tightened: bool) -> sparse.csc_array:
    """The matrix T of ``u = T q`` of motion symmetric about the width, as ``free_displacements``.

    Raises
    ------
    ValueError
        If the mesh is not symmetric about y = 0.
    """
    T = free_displacements(assembly, tightened=False)
    symmetric = T @ _unknowns_of_half(T, _mirrored_nodes(assembly), 1.0)
    if not tightened:
        return symmetric.tocsc()
    # the bolts lie on the plane of symmetry
    shortening = free_displacements(assembly, tightened=True)[:, T.shape[1] :]
    return sparse.hstack([symmetric, shortening], format="csc")


def _mirrored_nodes(assembly: xr.Dataset) -> NDArray[np.int64]:
    """The node on the other side of y = 0 of every node."""
    coordinate = assembly["coordinate"].to_numpy()
    part = assembly["part"].to_numpy().astype(np.int64)
    connectivity = assembly["connectivity"].to_numpy()
    # nodes at one place belong to different bodies, or to the two sides of a pretension section
    body = np.full(len(coordinate), part.max() + 1)
    np.minimum.at(body, connectivity, part[:, None])
    body[assembly["section_node"].to_numpy()[:, 1]] += part.max() + 1
    mirrored = np.empty(len(coordinate), dtype=np.int64)
    for each in np.unique(body):
        node = np.flatnonzero(body == each)
        distance, nearest = cKDTree(coordinate[node]).query(coordinate[node] * [1, -1, 1])
        if distance.max() > 1e-9 * np.ptp(coordinate[:, 1]):
            raise ValueError("the mesh is not symmetric about y = 0")
        mirrored[node] = node[nearest]
    return mirrored


def _unknowns_of_half(
    T: sparse.csc_array, mirrored_node: NDArray[np.int64], sense: float
) -> sparse.csc_array:
    """The matrix that takes unknowns of symmetric motion to those of ``u = T q``.

    With the sense -1 of antisymmetric motion.
    """
    displacement = T.indices[T.indptr[:-1]]
    node, axis = np.divmod(displacement, 3)
    # every free displacement follows one unknown; held displacements are not used
    follows = np.zeros(T.shape[0], dtype=np.int64)
    follows[T.indices] = np.repeat(np.arange(T.shape[1]), np.diff(T.indptr))
    image = follows[3 * mirrored_node[node] + axis]
    sign = sense * np.where(axis == 1, -1.0, 1.0)
    own = np.arange(T.shape[1])
    # on the plane of symmetry nothing moves across it, or nothing moves along it
    kept = np.flatnonzero((own < image) | ((own == image) & (sign > 0)))
    column = np.arange(kept.size)
    two = image[kept] != kept
    return sparse.csc_array(
        (
            np.concatenate([np.ones(kept.size), sign[kept][two]]),
            (np.concatenate([kept, image[kept][two]]), np.concatenate([column, column[two]])),
        ),
        shape=(T.shape[1], kept.size),
    )
