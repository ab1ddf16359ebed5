"""One-sided tangents at a corner of a piecewise smooth branch, and the ways on from it.

Where a contact changes its state, the Jacobian jumps, and the branch has a tangent on either side
of the corner. The two may enclose any angle, so that a predictor along the one finds nothing on the
other: often the branch turns back almost onto itself. Every Jacobian around the corner is asked for
its null vector, and the branch is sought along both senses of each.

What tells the way on from the way back is not the angle between them but the orientation of the
branch: the sign of det [J; t], t the tangent in the sense of travel, stays the same along a
piecewise linear path (Allgower and Georg 1990, chapter 14) and is opposite for the way back.

References
----------
E. L. Allgower, K. Georg: Numerical Continuation Methods. Springer, 1990.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from boltjoint.solvers.equations import Matrix, Vector

if TYPE_CHECKING:
    from boltjoint.solvers.arc_length import Corrected, Corrector, Station

#: directions along which the branch is sought at most
_MOST_DIRECTIONS = 60

#: random directions in which Jacobians are evaluated, after those that Jacobians themselves give
_RANDOM_DIRECTIONS = 10

#: cosine above which two directions are one
_SAME = 0.999999


def ways_on(corrector: Corrector, station: Station, radius: float) -> list[Corrected]:
    """Solutions on a small sphere that continue the branch beyond a corner within.

    Parameters
    ----------
    corrector
        Of the branch.
    station
        The last solution before the corner, with the tangent of its own Jacobian.
    radius
        Of the sphere around it, larger than the distance of the corner.

    Returns
    -------
    list of Corrected
        The one farthest ahead first; empty where none was found.
    """
    random = np.random.default_rng(0)  # the same directions on every run
    tried: list[Vector] = []
    found: list[tuple[Vector, Corrected]] = []
    waiting, drawn = [np.zeros_like(station.tangent), station.tangent], 0
    sense = None
    while len(tried) < _MOST_DIRECTIONS:
        if not waiting:
            if drawn == _RANDOM_DIRECTIONS:
                break
            drawn += 1
            waiting.append(_unit(random.normal(size=station.tangent.size)))
        around = waiting.pop(0)
        x, p = station.at(radius * around)
        residual, jacobian_at = corrector.equations.evaluate(x, p)
        derivative = corrector.derivative(x, p, jacobian_at(), station.weights)
        if not np.all(np.isfinite(derivative)):
            continue
        if sense is None:
            sense = _orientation(derivative, station.tangent)
        for direction in _crossings(residual / radius, derivative, around):
            if any(direction @ other > _SAME for other in tried):
                continue
            tried.append(direction)
            waiting.append(direction)
            corrected = corrector.correct(station, radius, direction, sharp=True)
            if corrected is None:
                continue
            x, p = corrected.solution.x, corrected.solution.p
            way = _unit(corrected.offset * station.weights)
            derivative = corrector.derivative(x, p, corrected.jacobian, station.weights)
            if _orientation(derivative, way) != sense:
                continue
            if not any(way @ other > _SAME for other, _ in found):
                found.append((way, corrected))
    found.sort(key=lambda each: -each[0] @ station.tangent)
    return [corrected for _, corrected in found]


def _crossings(residual: Vector, derivative: Matrix, around: Vector) -> list[Vector]:
    """Where the branch of equations linearised at a point crosses the unit sphere.

    That branch is the line along the null vector of the derivative; where it misses the sphere, the
    two senses of that vector.
    """
    left, values, right = np.linalg.svd(derivative)
    null, rank = right[-1], len(values)
    if values[-1] <= np.finfo(float).eps * values[0]:
        return [null, -null]
    nearest = around - right[:rank].T @ ((left.T @ residual) / values)
    nearest = nearest - (nearest @ null) * null
    beside = 1.0 - nearest @ nearest
    if beside <= 0:
        return [null, -null]
    half = np.sqrt(beside) * null
    return [nearest + half, nearest - half]


def _orientation(derivative: Matrix, direction: Vector) -> float:
    """Sign of the determinant of the derivative bordered by a direction."""
    return float(np.linalg.slogdet(np.vstack([_scaled(derivative), direction]))[0])


def _scaled(derivative: Matrix) -> Matrix:
    return derivative / np.linalg.norm(derivative, axis=1, keepdims=True)


def _unit(vector: Vector) -> Vector:
    return vector / np.linalg.norm(vector)
