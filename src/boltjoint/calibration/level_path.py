"""Solutions of equations along ascending amplitudes, and neighbours of a model for derivatives.

Used for modes (``backbone_points``) and for forced motion (``response_points``) at the amplitudes
that a sensor measured.
"""

from collections.abc import Callable, Sequence
from math import sqrt
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgetrf, dgetrs

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance

Array = NDArray[np.float64]

#: iterations of Newton's method, and relative change of the unknown at which it ends
_ITERATIONS, _TOLERANCE = 12, 1e-9

#: how far the correction of a step may lead, and how often a step in amplitude is halved
_LARGEST, _HALVINGS = 0.5, 10

#: difference of levels that is rounding
_SAME = 1e-12

#: what a correction with the factors of the one before may leave, over the tolerance
_KEPT = 1e-6

#: second term of a guess over the first one, at most
_LARGEST_BEND = 0.3

#: step of central differences of the residual: their error, its square, is as small as rounding
_STEP = 1e-6


class NotReached(ValueError):
    """A motion that was not found at a measured amplitude."""


class LUFactors(NamedTuple):
    """LU factors of a matrix, and the rows that were exchanged."""

    lower_and_upper: Array
    pivots: NDArray[np.int32]

    @classmethod
    def of(cls, matrix: Array) -> "LUFactors | None":
        """Those of a matrix; None where it is singular or not finite."""
        lower_and_upper, pivots, singular = dgetrf(matrix)
        if singular or not np.all(np.isfinite(lower_and_upper.diagonal())):
            return None
        return cls(lower_and_upper, pivots)

    def solve(self, right: Array) -> Array:
        """Solutions with right sides, (unknowns,) or (unknowns, sides)."""
        return dgetrs(self.lower_and_upper, self.pivots, right)[0]


class LevelCurve(NamedTuple):
    """What was solved at the points of a curve, with derivatives.

    Attributes
    ----------
    values
        Shape (points, quantities).
    by_amplitude, by_parameter
        Derivatives by the logarithm of the amplitude, (points, quantities), and by each parameter
        in its scale, (points, quantities, parameters); of no points where no parameter is asked
        for.
    """

    values: Array
    by_amplitude: Array
    by_parameter: Array

    @classmethod
    def of(cls, values: Array, slopes: Array | None) -> "LevelCurve":
        """From values of each point, and their derivatives by ln(amplitude) and all parameters.

        Shapes (points, quantities) and (points, quantities, 1 + parameters), None without any.
        """
        derivatives = np.empty((0, values.shape[1], 1)) if slopes is None else slopes
        return cls(values, derivatives[:, :, 0], derivatives[:, :, 1:])


class SensedBalance(NamedTuple):
    """A balance whose motion a sensor measures.

    Attributes
    ----------
    balance
        Of the joint.
    row
        Modes at the sensor, shape (linear modes,); None for the modal amplitude.
    """

    balance: HarmonicBalance
    row: Array | None


#: a balance with a lower and a higher value of a parameter, and the difference of both in its
#: scale; None where it changes neither joint nor damping
Neighbours = tuple[SensedBalance, SensedBalance, float] | None


class LevelSystem(Protocol):
    """Equations of a motion whose last one sets the logarithm of the amplitude of a sensor."""

    def residual(self, y: Array, level: float) -> Array:
        """Residual at an unknown, and at a level of ln(amplitude)."""
        ...

    def factors(self, y: Array) -> LUFactors | None:
        """Factors of the Jacobian where the residual was evaluated last; None if singular."""
        ...

    def is_possible(self, y: Array) -> bool:
        """Whether an unknown may be one of a motion: no negative square of a frequency."""
        ...


class LevelPath:
    """The motion at one ln(amplitude) after another, each guessed from those before.

    Parameters
    ----------
    system, guess, level
        Equations, and a guess of their solution at the first level.

    Raises
    ------
    NotReached
        If there is no motion near the guess.
    """

    def __init__(self, system: LevelSystem, guess: Array, level: float) -> None:
        self._system = system
        found = corrected(system, guess, level)
        if found is None:
            raise _not_reached(level)
        y, factors = found
        self.y, self.level, self._factors = y, level, factors
        self._tangent, self._bend = self._slope(), np.zeros_like(y)

    def advance(self, end: float) -> None:
        """Go to a higher level, in as many steps as it needs."""
        length, halvings = end - self.level, 0
        while self.level < end:
            level = end if self.level + length >= end - _SAME else self.level + length
            step = level - self.level
            guess = self.y + step * self._tangent
            bend = step**2 / 2 * self._bend
            # across a corner of the law slopes tell nothing of what follows
            if _length(bend) <= _LARGEST_BEND * _length(step * self._tangent):
                guess += bend
            found = corrected(self._system, guess, level)
            if found is None:
                halvings += 1
                if halvings > _HALVINGS:
                    raise _not_reached(level)
                length /= 2
                continue
            before = self._tangent
            self.y, self._factors = found
            self.level = level
            self._tangent = self._slope()
            self._bend = (self._tangent - before) / step

    def _slope(self) -> Array:
        """Derivative of the unknown by the level."""
        right = np.zeros_like(self.y)
        right[-1] = 1.0
        return self._factors.solve(right)


def _length(x: Array) -> float:
    """Euclidean norm, in a fraction of the time that NumPy's takes for a few numbers."""
    return sqrt(x @ x)


def _not_reached(level: float) -> NotReached:
    return NotReached(f"no motion was found at the amplitude {np.exp(level):.3g}")


def corrected(system: LevelSystem, y: Array, level: float) -> tuple[Array, LUFactors] | None:
    """Newton's method at a level of ln(amplitude), with factors near there; None if it fails.

    A correction with the factors of the one before is the last where it is so much smaller that
    what it leaves, which falls about as fast again, is far below the tolerance.
    """
    factors, before = None, 0.0
    for _ in range(_ITERATIONS):
        if not (np.all(np.isfinite(y)) and system.is_possible(y)):
            return None
        residual = system.residual(y, level)
        if factors is not None:
            change = factors.solve(residual)
            size = _length(change)
            if size**2 <= _KEPT * _TOLERANCE * _length(y) * before:
                return y - change, factors
        factors = system.factors(y)
        if factors is None:
            return None
        change = factors.solve(residual)
        size = _length(change)
        is_whole = size <= _LARGEST
        y = y - change * (1.0 if is_whole else _LARGEST / size)
        if size <= _TOLERANCE * _length(y):
            return y, factors
        before = size if is_whole else 0.0
    return None


def neighbours_of(
    balance_at: Callable[[Array], SensedBalance], scaled: Array, bounds: tuple[Array, Array]
) -> list[Neighbours]:
    """A balance on both sides of each parameter within its bounds, and the difference of both.

    Parameters
    ----------
    balance_at
        The balance by parameters in their scales.
    scaled, bounds
        The parameters, and lowest and highest of each.
    """
    pairs: list[Neighbours] = []
    for n in range(scaled.size):
        step = _STEP * max(abs(scaled[n]), 1.0)
        low, high = scaled.copy(), scaled.copy()
        # beyond its bounds a parameter may mean nothing
        low[n] = max(low[n] - step, min(bounds[0][n], low[n]))
        high[n] = min(high[n] + step, max(bounds[1][n], high[n]))
        below, above = balance_at(low), balance_at(high)
        is_same = (
            below.balance.joint is above.balance.joint
            and below.balance.damping is above.balance.damping
        )
        pairs.append(None if is_same else (below, above, high[n] - low[n]))
    return pairs


def change_by_parameters(
    residuals: Callable[[SensedBalance], Array], neighbours: Sequence[Neighbours], unknowns: Array
) -> Array:
    """What the equations ask of the unknowns by ln(amplitude) and by each parameter.

    Parameters
    ----------
    residuals
        Residuals of another balance at the unknowns, of the shape of these.
    neighbours
        Of each parameter.
    unknowns
        Solutions, shape (points, unknowns).

    Returns
    -------
    ndarray
        Right sides of the equations with the Jacobian, (points, unknowns, 1 + parameters).
    """
    right = np.zeros((*unknowns.shape, 1 + len(neighbours)))
    right[:, -1, 0] = 1.0
    for n, pair in enumerate(neighbours, start=1):
        if pair is not None:
            low, high, difference = pair
            right[:, :, n] = (residuals(low) - residuals(high)) / difference
    return right
