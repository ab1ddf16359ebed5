"""Newton's method with step halving at a fixed parameter, with all Jacobians or with few of them.

Where a Jacobian costs as much as a hundred residuals, one is factorized and then preconditions
GMRES at the solutions near it, which needs products with the derivative alone. Differences of
residuals will not do for these: with changes from 1e-10 to 1e-3 of the unknown, corners of the
friction law or rounding kept GMRES from converging.

References
----------
C. T. Kelley: Solving Nonlinear Equations with Newton's Method. SIAM, 2003: chapter 2, on the
chord method.
D. A. Knoll, D. E. Keyes: Jacobian-free Newton-Krylov methods: a survey of approaches and
applications. Journal of Computational Physics 193 (2004) 357-397.
"""

from collections.abc import Callable
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs
from scipy.sparse.linalg import LinearOperator, gmres

from boltjoint.solvers.equations import (
    Derivative,
    Equations,
    LazyJacobian,
    Matrix,
    Precision,
    Solution,
    Vector,
)
from boltjoint.solvers.step_control import StepControl

#: a residual this small against the terms it is the sum of is their rounding
ROUNDING = 4 * np.finfo(float).eps

#: largest reduction of the residual by a correction whose Jacobian serves the next one too: a chord
#: correction costs a tenth of one with a new Jacobian, or less
_CHORD_REDUCTION = 0.1


def newton(
    equations: Equations, x: Vector, p: float, control: StepControl, *, chords: bool = False
) -> tuple[Solution, Matrix]:
    """Solve the equations at a fixed parameter, halving corrections that do not help.

    Parameters
    ----------
    equations, control
        The system, tolerance and number of iterations.
    x, p
        Initial guess, and the parameter.
    chords
        Whether a Jacobian is kept while its corrections converge fast, as from near guesses.

    Returns
    -------
    solution : Solution
        ``converged`` is false where ``maximum_iterations`` did not suffice.
    jacobian : ndarray
        Of the last correction, which differs from that at the solution by less than it corrected;
        where there was none, at the solution.
    """
    residual, jacobian_at = equations.evaluate(x, p)
    size, jacobian = float(np.linalg.norm(residual)), jacobian_at()
    kept = True
    for iteration in range(control.maximum_iterations):
        limit = smallest_residual(equations, control, x, jacobian)
        if not kept and size > limit:
            jacobian = jacobian_at()
        correction = solve(jacobian, residual) if size > limit else None
        if correction is None:
            return Solution(x, p, iteration, bool(size <= limit)), jacobian
        x, residual, jacobian_at = corrected(equations, x, p, correction, size)
        before, size = size, float(np.linalg.norm(residual))
        kept = chords and size <= _CHORD_REDUCTION * before
    limit = smallest_residual(equations, control, x, jacobian)
    return Solution(x, p, control.maximum_iterations, bool(size <= limit)), jacobian


def corrected(
    equations: Equations, x: Vector, p: float, correction: Vector, size: float
) -> tuple[Vector, Vector, LazyJacobian]:
    """Unknown less its correction, halved until the residual falls below a size; with residual.

    A correction that does not help at any length may still lead out of a corner of the law. Where
    one leads too far for numbers, its residual is not finite.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        for damping in (1.0, 0.5, 0.25, 0.125):
            trial = x - damping * correction
            residual, derivative = equations.evaluate(trial, p)
            if np.linalg.norm(residual) < size:
                break
    return trial, residual, derivative


def smallest_residual(
    equations: Equations, control: StepControl, x: Vector, jacobian: Matrix
) -> float:
    """The residual that counts as zero: by the tolerance, or the rounding of its own terms.

    At a sharp resonance the terms are orders of magnitude larger than what they balance.
    """
    return max(control.tolerance * equations.residual_scale, rounding(jacobian, x))


def rounding(jacobian: Matrix, x: Vector) -> float:
    """Rounding of a residual by that of the terms it is the sum of."""
    size = abs(x)
    # rows together, so that no second matrix is made
    terms = [abs(rows) @ size for rows in _blocks_of_rows(jacobian)]
    return ROUNDING * float(np.linalg.norm(np.concatenate(terms)))


def _blocks_of_rows(matrix: NDArray[np.floating]) -> list[NDArray[np.floating]]:
    """Rows of a matrix, some at a time."""
    return [matrix[first : first + _ROWS_AT_ONCE] for first in range(0, len(matrix), _ROWS_AT_ONCE)]


def solve(matrix: Matrix, right: Vector) -> Vector | None:
    """Solution of a linear system; None where it is singular or overflows."""
    try:
        solution = cast(Vector, np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        return None
    return solution if np.all(np.isfinite(solution)) else None


#: residual of the linear equations of a correction over their right side; where it depended on how
#: far the one before helped (Eisenstat and Walker 1996), motions at folds were not found
_CORRECTION = 0.1
#: tolerance of a solution over that of GMRES
_ROUNDED = 1.1
#: iterations of GMRES beyond which new factors cost less: over the number of unknowns, and at least
_ITERATIONS_BY_UNKNOWNS, _ITERATIONS = 1 / 80, 5
#: rows of a matrix whose copy stays in the cache
_ROWS_AT_ONCE = 64
#: unknowns whose factors take little time
_IN_DOUBLE_PRECISION = 500


class NewtonKrylov:
    """Solutions of equations near each other, whose corrections share the factors of a Jacobian.

    Parameters
    ----------
    equations, control
        The system, whose ``evaluate`` gives a ``Derivative``, tolerance and number of iterations.
    near
        Solutions of other equations near these, with which they share factors.
    """

    def __init__(
        self, equations: Equations, control: StepControl, near: "NewtonKrylov | None" = None
    ) -> None:
        self._equations, self._control = equations, control
        self._factors: KeptFactors = KeptFactors() if near is None else near._factors
        self._rounding: float = 0.0 if near is None else near._rounding

    def solve(self, x: Vector, p: float) -> Solution:
        """Solve the equations at a fixed parameter, halving corrections that do not help.

        Parameters
        ----------
        x, p
            Initial guess, and the parameter.

        Returns
        -------
        Solution
            ``converged`` is false where ``maximum_iterations`` did not suffice, or residuals became
            larger than numbers.
        """
        residual, derivative = self._equations.evaluate(x, p)
        for iteration in range(self._control.maximum_iterations):
            # beyond all numbers it is infinite
            with np.errstate(over="ignore"):
                size = float(np.linalg.norm(residual))
            if not np.isfinite(size):
                return Solution(x, p, iteration, converged=False)
            if size <= self._limit:
                return Solution(x, p, iteration, converged=True)
            correction = self._solve(x, cast(Derivative, derivative), residual, _CORRECTION)
            if correction is None:
                return Solution(x, p, iteration, converged=False)
            x, residual, derivative = corrected(self._equations, x, p, correction, size)
        converged = bool(np.linalg.norm(residual) <= self._limit)
        return Solution(x, p, self._control.maximum_iterations, converged)

    @property
    def _limit(self) -> float:
        """The residual that counts as zero: by the tolerance, or the rounding of its own terms."""
        return max(self._control.tolerance * self._equations.residual_scale, self._rounding)

    def _solve(
        self, x: Vector, derivative: Derivative, right: Vector, tolerance: float
    ) -> Vector | None:
        """Solution of the linear equations with a right side; None if they are singular."""

        def jacobian(precision: Precision) -> Matrix:
            matrix = derivative(precision)
            self._rounding = rounding(matrix, x)
            return matrix

        return self._factors.solve(derivative.along, jacobian, right, tolerance)


class KeptFactors:
    """Linear equations near each other, by GMRES with the factors of the matrix of one of them."""

    def __init__(self) -> None:
        self._factors: _Factors | None = None
        self._precision: Precision = np.float32

    def solve(
        self,
        along: Callable[[Vector], Vector],
        matrix: Callable[[Precision], Matrix],
        right: Vector,
        tolerance: float,
    ) -> Vector | None:
        """Solve with the factors there are if GMRES converges, and otherwise with new ones.

        Parameters
        ----------
        along, matrix
            Product of the matrix with a vector, and the matrix in the precision of its factors.
        right
            Right side.
        tolerance
            Residual of GMRES over the right side.

        Returns
        -------
        ndarray or None
            None where the matrix is singular or not finite.
        """
        solution = self._precondition(along, right, tolerance)
        if solution is not None:
            return solution
        if right.size <= _IN_DOUBLE_PRECISION:
            self._precision = np.float64
        jacobian = self._factorize(matrix)
        solution = self._precondition(along, right, tolerance)
        if solution is None and self._precision is np.float32:
            # near a sharp resonance terms cancel to a millionth of themselves
            self._precision = np.float64
            jacobian = self._factorize(matrix)
            solution = self._precondition(along, right, tolerance)
        return solve(jacobian, right) if solution is None else solution

    def _factorize(self, matrix: Callable[[Precision], Matrix]) -> Matrix:
        """Keep the factors of the matrix, which is returned."""
        evaluated = matrix(self._precision)
        self._factors = _Factors.of(evaluated, self._precision)
        return evaluated

    def _precondition(
        self, along: Callable[[Vector], Vector], right: Vector, tolerance: float
    ) -> Vector | None:
        """Solution by GMRES; None without factors, or if it does not converge."""
        if self._factors is None:
            return None
        factors, n = self._factors, right.size
        most = max(_ITERATIONS, round(_ITERATIONS_BY_UNKNOWNS * n))
        operator = LinearOperator((n, n), lambda y: along(factors.solve(y)), dtype=float)
        solution = factors.solve(gmres(operator, right, rtol=tolerance, restart=most, maxiter=1)[0])
        # rounding of the factors may leave what is solved just above
        remains = np.linalg.norm(right - along(solution))
        return solution if remains <= _ROUNDED * tolerance * np.linalg.norm(right) else None


class _Factors(NamedTuple):
    """Factors of the transpose of a matrix whose rows and columns are scaled to 1.

    Those in single precision mostly precondition GMRES as well, and take half of the time.
    """

    rows: Vector
    columns: Vector
    factors: NDArray[np.floating]
    pivots: NDArray[np.int32]

    @classmethod
    def of(cls, matrix: Matrix, precision: Precision) -> "_Factors | None":
        """Factors of a matrix; None where it is singular or not finite."""
        columns = np.zeros(len(matrix))
        for part in _blocks_of_rows(matrix):
            np.maximum(columns, abs(part).max(axis=0), out=columns)
        if not np.all(np.isfinite(columns)) or not np.all(columns):
            return None
        rows, scaled = np.empty(len(matrix)), np.empty(matrix.shape, precision)
        for of_rows, of_scaled, part in zip(
            *map(_blocks_of_rows, (rows, scaled, matrix)), strict=True
        ):
            by_columns = part / columns
            of_rows[:] = abs(by_columns).max(axis=1)
            np.divide(by_columns, of_rows[:, None], out=of_scaled, casting="same_kind")
        if not np.all(rows):
            return None
        # by columns it is the transpose
        getrf = get_lapack_funcs("getrf", (scaled,))
        factors, pivots, singular = getrf(scaled.T, overwrite_a=True)
        return None if singular else cls(rows, columns, factors, pivots)

    def solve(self, right: Vector) -> Vector:
        """Solution with a right side, to the precision of the factors."""
        scaled = (right / self.rows).astype(self.factors.dtype)
        solve = get_lapack_funcs("getrs", (self.factors,))
        solution, _ = solve(self.factors, self.pivots, scaled, trans=1, overwrite_b=True)
        return solution / self.columns
