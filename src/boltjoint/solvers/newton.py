"""Newton's method with step halving at a fixed parameter.

References
----------
C. T. Kelley: Solving Nonlinear Equations with Newton's Method. SIAM, 2003: chapter 2, on the
chord method.
"""

import numpy as np

from boltjoint.solvers.equations import (
    Equations,
    LazyJacobian,
    Matrix,
    Solution,
    StepControl,
    Vector,
)

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
    size, jacobian = np.linalg.norm(residual), jacobian_at()
    kept = True
    for iteration in range(control.maximum_iterations):
        limit = smallest_residual(equations, control, x, jacobian)
        if not kept and size > limit:
            jacobian = jacobian_at()
        correction = solve(jacobian, residual) if size > limit else None
        if correction is None:
            return Solution(x, p, iteration, bool(size <= limit)), jacobian
        x, residual, jacobian_at = corrected(equations, x, p, correction, size)
        before, size = size, np.linalg.norm(residual)
        kept = chords and size <= _CHORD_REDUCTION * before
    limit = smallest_residual(equations, control, x, jacobian)
    return Solution(x, p, control.maximum_iterations, bool(size <= limit)), jacobian


def corrected(
    equations: Equations, x: Vector, p: float, correction: Vector, size: float
) -> tuple[Vector, Vector, LazyJacobian]:
    """Unknown less its correction, halved until the residual falls below a size; with residual.

    A correction that does not help at any length may still lead out of a corner of the law.
    """
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
    return ROUNDING * float(np.linalg.norm(abs(jacobian) @ abs(x)))


def solve(matrix: Matrix, right: Vector) -> Vector | None:
    """Solution of a linear system; None where it is singular or overflows."""
    try:
        solution = np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return None
    return solution if np.all(np.isfinite(solution)) else None
