"""Attachment modes of a contact: static shapes of unit forces on its points, and their matrices.

A structure of n unknowns has two for each of c points. Where 2 c n numbers are too many to be in
memory together they are solved for in blocks, and twice: with C the rows of the points, of
``V = K^-1 C^T`` are needed only

    C V   and   V^T M V = C K^-1 (M V)

until the few combinations of them are known that are kept, whose shapes are solved for then.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

if TYPE_CHECKING:
    from boltjoint.structure.factors import Factors
    from boltjoint.structure.subspaces import Subspace

Array = NDArray[np.float64]

#: right sides solved at a time: many enough that the factors are read seldom, few enough for memory
_BLOCK = 64

#: size of all vectors [byte] up to which they are kept; results differ by rounding
_KEPT = 2**31


class SolvedVectors:
    """Modes and attachment modes of which combinations are solved for, not kept.

    Parameters
    ----------
    part
        The motion of the structure.
    mode
        Modes, shape (unknowns, modes).
    rows
        C, shape (attachment modes, unknowns).
    """

    def __init__(self, part: "Subspace", mode: Array, rows: sparse.csr_array) -> None:
        self._part, self._mode, self._rows = part, mode, rows

    def __matmul__(self, factor: Array) -> Array:
        """Combinations, shape (unknowns, combinations), by factors (vectors, combinations)."""
        modes = self._mode.shape[1]
        factors = self._part.factors(self._part.stiffness)
        shape = self._mode @ factor[:modes]
        for first in range(0, factor.shape[1], _BLOCK):
            block = slice(first, first + _BLOCK)
            shape[:, block] += factors.solve(self._rows.T @ factor[modes:, block])
        return shape


def attachment_modes(
    part: "Subspace", factors: "Factors", mode: Array, rows: sparse.csr_array
) -> tuple[Array | SolvedVectors, Array, Array]:
    """Modes and attachment modes V, their motion C V and their mass V^T M V.

    Parameters
    ----------
    part
        The motion of the structure.
    factors
        Factors of its stiffness.
    mode
        Modes, shape (unknowns, modes).
    rows
        C, shape (attachment modes, unknowns).

    Returns
    -------
    tuple
        V, shape (unknowns, vectors), or what makes combinations of them; C V, shape (attachment
        modes, vectors); V^T M V, shape (vectors, vectors).
    """
    modes, count = mode.shape[1], mode.shape[1] + rows.shape[0]
    if mode.itemsize * mode.shape[0] * count > _KEPT:
        return SolvedVectors(part, mode, rows), *_solved_twice(part, factors, mode, rows)
    vector = np.empty((mode.shape[0], count), order="F")
    vector[:, :modes] = mode
    for block in _blocks(rows):
        force = rows[block].T.toarray()
        vector[:, modes + block.start :][:, : force.shape[1]] = factors.solve(force)
    return vector, rows @ vector, _projected(part.mass, vector)


def _solved_twice(
    part: "Subspace", factors: "Factors", mode: Array, rows: sparse.csr_array
) -> tuple[Array, Array]:
    """C V and V^T M V, a block of V at a time."""
    modes, count = mode.shape[1], mode.shape[1] + rows.shape[0]
    moved, mass = np.empty((rows.shape[0], count)), np.empty((count, count))
    moved[:, :modes] = rows @ mode
    mass[:modes, :modes] = mode.T @ (part.mass @ mode)
    for block in _blocks(rows):
        columns = slice(modes + block.start, modes + block.stop)
        shape = factors.solve(rows[block].T.toarray())
        inertia = part.mass @ shape
        moved[:, columns] = rows @ shape
        mass[:modes, columns] = mode.T @ inertia
        mass[modes:, columns] = rows @ factors.solve(inertia)
    mass[modes:, :modes] = mass[:modes, modes:].T
    return moved, symmetric_part(mass)


def _blocks(rows: sparse.csr_array) -> list[slice]:
    """Rows that are solved for together."""
    starts = range(0, rows.shape[0], _BLOCK)
    return [slice(first, min(first + _BLOCK, rows.shape[0])) for first in starts]


def _projected(matrix: sparse.csc_array, vector: Array) -> Array:
    """V^T A V of symmetric A, a block of columns at a time, since A V is as large as V."""
    count = vector.shape[1]
    projection = np.zeros((count, count))
    for first in range(0, count, _BLOCK):
        block = slice(first, first + _BLOCK)
        projection[: first + _BLOCK, block] = vector[:, : first + _BLOCK].T @ (
            matrix @ vector[:, block]
        )
    upper = np.triu(projection)
    return upper + np.triu(upper, 1).T


def symmetric_part(matrix: Array) -> Array:
    """Half the sum of a matrix and its transpose."""
    return (matrix + matrix.T) / 2
