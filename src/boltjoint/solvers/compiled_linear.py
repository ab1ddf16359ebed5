"""Vectors and linear systems of compiled loops: small ones in place, large ones by LAPACK."""

from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import call_c, kept_loop, loop, summing_loop

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

#: systems up to this size are solved in place, larger ones by LAPACK
LARGEST_ELIMINATED = 40


class Work(NamedTuple):
    """Arrays of a loop: a solution x with its offset in distances, and linear systems.

    ``outcome``: iterations of a solution, and whether it converged; ``sign`` as of
    ``solve_in_place``, and from ``columns`` on what it gives to LAPACK.
    """

    x: Vector
    offset: Vector
    residual: Vector
    jacobian: Matrix
    by_parameter: Vector
    matrix: Matrix
    right: Vector
    trial: Vector
    outcome: NDArray[np.int64]
    sign: Vector
    columns: Vector
    pivots: NDArray[np.int32]
    order: NDArray[np.int32]
    single: NDArray[np.int32]
    info: NDArray[np.int32]


def make_work(n: int) -> Work:
    """The arrays for n unknowns."""
    m = n + 1
    return Work(
        *(np.zeros(n), np.zeros(m), np.zeros(n), np.zeros((n, n)), np.zeros(n)),
        *(np.zeros((m, m)), np.zeros(m), np.zeros(n), np.zeros(2, np.int64), np.zeros(1)),
        *(np.zeros(m * m), np.zeros(m, np.int32)),
        *(np.zeros(1, np.int32), np.ones(1, np.int32), np.zeros(1, np.int32)),
    )


@loop
def copy_to(target: Vector, source: Vector) -> None:
    """Copy one vector to another: a loop that costs less to compile than an assignment."""
    for i in range(source.size):
        target[i] = source[i]


@summing_loop
def norm(vector: Vector) -> float:
    """Euclidean norm."""
    total = 0.0
    for value in vector:
        total += value * value
    return sqrt(total)


@kept_loop
def solve_in_place(lapack: int, work: Work, n: int) -> None:
    """Solve ``matrix`` for the first n of ``right``; ``sign`` is that of the determinant.

    The sign is 0 if that fails. Gaussian elimination with partial pivoting: of small systems in
    ``matrix`` itself, of large ones by LAPACK's ``dgesv`` at this address.
    """
    matrix, right, sign = work.matrix, work.right, 1.0
    if n > LARGEST_ELIMINATED:
        columns, pivots = work.columns, work.pivots
        for j in range(n):
            for i in range(n):
                columns[j * n + i] = matrix[i, j]
        work.order[0] = n
        order, info = work.order, work.info
        call_c(lapack, order, work.single, columns, order, pivots, right, order, info)
        for k in range(n):
            if (columns[k * n + k] < 0.0) != (pivots[k] != k + 1):
                sign = -sign
            if not isfinite(right[k]):
                sign = 0.0
        work.sign[0] = sign if info[0] == 0 else 0.0
        return
    work.sign[0] = 0.0
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if not abs(matrix[pivot, k]) > 0.0:
            return
        if matrix[pivot, k] < 0.0:
            sign = -sign
        if pivot != k:
            sign = -sign
            for j in range(k, n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            right[k], right[pivot] = right[pivot], right[k]
        for i in range(k + 1, n):
            factor = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, n):
                matrix[i, j] -= factor * matrix[k, j]
            right[i] -= factor * right[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]
        if not isfinite(right[k]):
            return
    work.sign[0] = sign
