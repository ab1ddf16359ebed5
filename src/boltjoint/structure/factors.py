"""Factors of stiffness matrices, and the check that a structure is held."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

Array = NDArray[np.float64]

#: advice where a structure is not held
_HELD = (
    "a part of the assembly is not held, or its stiffnesses are too far apart: check that its "
    "elements are not much longer than wide, and that its material is nearer to steel"
)

#: share of the highest squared frequency below which others are lost in rounding
ROUNDING_OF_FREQUENCIES = 1e-13


def factorise(matrix: sparse.csc_array) -> SuperLU:
    """LU factors of a sparse matrix that is symmetric, or nearly so, and needs no pivoting.

    Raises
    ------
    ValueError
        If the matrix is not sparse and square.
    RuntimeError
        If the matrix is singular.
    """
    if not (sparse.issparse(matrix) and matrix.ndim == 2 and matrix.shape[0] == matrix.shape[1]):
        raise ValueError("matrix must be sparse and square")
    # Pivots on the diagonal keep the fill of a symmetric ordering (SuperLU users' guide, 2.2).
    # Joining no columns into larger supernodes (relax) saves these matrices a tenth of the fill.
    try:
        return splu(
            matrix.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            relax=1,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise RuntimeError(f"the stiffness matrix is singular: {_HELD}") from error


def check_held(squared: Array, stiffness: sparse.csc_array, mass: sparse.csc_array) -> None:
    """Refuse natural frequencies that a structure which is held cannot have.

    Parameters
    ----------
    squared
        Squares of the natural circular frequencies of elastic modes [s^-2], shape (modes,).
    stiffness, mass
        K and M.

    Raises
    ------
    RuntimeError
        If one of them is no number, or zero within rounding, as of a rigid-body mode.
    """
    lost = ~(squared > ROUNDING_OF_FREQUENCIES * highest_frequency(stiffness, mass))
    if lost.any():
        raise RuntimeError(
            f"{np.count_nonzero(lost)} of {len(squared)} natural frequencies are zero within "
            f"rounding, or no numbers: {_HELD}"
        )


def highest_frequency(stiffness: sparse.csc_array, mass: sparse.csc_array) -> float:
    """An estimate from below of the largest squared frequency, whose rounding all of them have."""
    inertia = mass.diagonal()
    return float((stiffness.diagonal()[inertia > 0] / inertia[inertia > 0]).max())
