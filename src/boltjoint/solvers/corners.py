"""One-sided tangent directions at a corner of a piecewise smooth branch.

Where a contact changes its state, the Jacobian jumps, and the branch has a tangent on either side
of the corner. The two may enclose any angle, so that the corrector finds no solution along the
tangent before the corner: often the branch turns back almost onto itself. Tangent directions are
the null vectors of all Jacobians around the corner, and the branch is sought in both senses of
each.

The continuation of the branch is told from the part already followed by its orientation, not by an
angle: the sign of det [J; t], t the tangent in the sense of travel, stays the same along a
piecewise linear branch (Allgower and Georg 1990, chapter 14) and is opposite on the part before.

References
----------
E. L. Allgower, K. Georg: Numerical Continuation Methods. Springer, 1990.
"""

from typing import NamedTuple

import numpy as np

from boltjoint.solvers.corrector import Corrector, Predictor, Step, orientation_of
from boltjoint.solvers.equations import Matrix, SolutionBranch, Vector
from boltjoint.solvers.step_control import CORNER_STEP

#: cosine above which two directions from a corner are the same
_SAME_LINE = 0.9999

#: largest number of directions in which the branch is sought
_MAXIMUM_DIRECTIONS = 60

#: random directions in which Jacobians are evaluated, after those that Jacobians themselves give
_RANDOM_DIRECTIONS = 10

#: cosine above which two directions are one
_EQUAL_COSINE = 0.999999


def is_same_exit(one: Predictor, other: Predictor) -> bool:
    """Whether two solutions beyond a corner lie on the same line from it."""
    apart = np.append(one.x - other.x, one.p - other.p) * one.weights
    cosine = one.tangent @ (other.tangent / other.weights * one.weights)
    cosine /= np.linalg.norm(other.tangent / other.weights * one.weights)
    return bool(np.linalg.norm(apart) < 4 * CORNER_STEP and cosine > _SAME_LINE)


class Alternative(NamedTuple):
    """A continuation from a corner kept in reserve, and the state of the run at the corner."""

    branch: SolutionBranch
    step: Step
    length: float
    state: object
    orientation: float
    exits: list[Predictor]


def continuations(
    corrector: Corrector, predictor: Predictor, radius: float, orientation: float = 0.0
) -> list[Step]:
    """Steps onto a small sphere by which the branch continues beyond a corner within it.

    Parameters
    ----------
    corrector
        Corrector of the branch.
    predictor
        The last solution before the corner, with the tangent of its own Jacobian.
    radius
        Radius of the sphere around it, larger than the distance of the corner.
    orientation
        Orientation of the branch in the sense of travel; by default, with 0, that of the predictor.

    Returns
    -------
    list of Step
        That of the smallest turn first; empty where there is none.
    """
    random = np.random.default_rng(0)  # the same directions in every run
    tried: list[Vector] = []
    steps: list[tuple[Vector, Step]] = []
    queue, drawn = [np.zeros_like(predictor.tangent), predictor.tangent], 0
    while len(tried) < _MAXIMUM_DIRECTIONS:
        if not queue:
            if drawn == _RANDOM_DIRECTIONS:
                break
            drawn += 1
            queue.append(_unit(random.normal(size=predictor.tangent.size)))
        point = queue.pop(0)
        x, p = predictor.at(radius * point)
        residual, jacobian_at = corrector.equations.evaluate(x, p)
        jacobian = corrector.linear.linearise(jacobian_at)
        derivative = corrector.linear.derivative(x, p, jacobian, predictor.weights)
        if not np.all(np.isfinite(derivative)):
            continue
        if orientation == 0:
            orientation = orientation_of(derivative, predictor.tangent)
        for direction in _intersections(residual / radius, derivative, point):
            if any(direction @ other > _EQUAL_COSINE for other in tried):
                continue
            tried.append(direction)
            queue.append(direction)
            step = corrector.correct(predictor, radius, direction, update_jacobian=True)
            if step is None:
                continue
            x, p = step.solution.x, step.solution.p
            secant = _unit(step.offset * predictor.weights)
            derivative = corrector.linear.derivative(x, p, step.jacobian, predictor.weights)
            if orientation_of(derivative, secant) != orientation:
                continue
            if not any(secant @ other > _EQUAL_COSINE for other, _ in steps):
                steps.append((secant, step))
    steps.sort(key=lambda secant_and_step: -secant_and_step[0] @ predictor.tangent)
    return [step for _, step in steps]


def _intersections(residual: Vector, derivative: Matrix, point: Vector) -> list[Vector]:
    """Where the branch of equations linearised at a point intersects the unit sphere.

    That branch is the line along the null vector of the derivative; where it misses the sphere, the
    two senses of that vector.
    """
    left, values, right = np.linalg.svd(derivative)
    null, rank = right[-1], len(values)
    if values[-1] <= np.finfo(float).eps * values[0]:
        return [null, -null]
    nearest = point - right[:rank].T @ ((left.T @ residual) / values)
    nearest = nearest - (nearest @ null) * null
    square = 1.0 - nearest @ nearest
    if square <= 0:
        return [null, -null]
    half = np.sqrt(square) * null
    return [nearest + half, nearest - half]


def _unit(vector: Vector) -> Vector:
    return vector / np.linalg.norm(vector)
