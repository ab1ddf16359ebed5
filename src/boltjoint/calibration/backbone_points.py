"""Frequency and damping of a nonlinear mode at measured amplitudes, and their derivatives.

At each amplitude Newton's method solves the mode (``dynamics.backbone.epmc``) together with the
condition that its sensor has the measured amplitude. With the unknown y of this system r(y) = 0,
the implicit function theorem gives the derivatives by all parameters theta at once::

    dy/dtheta = -(dr/dy)^-1 dr/dtheta

with the matrix and derivatives of the residual at the solution.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgetrf, dgetrs

from boltjoint.dynamics.backbone.compiled_epmc import CompiledMode
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.measurement.signals import MOTIONS

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

#: first amplitude over the lowest measured one, where the stuck mode is a guess
_FIRST = 1e-3

#: step of central differences of the residual: their error, its square, is as small as rounding
_STEP = 1e-6


class NotReached(ValueError):
    """A mode that was not found at a measured amplitude."""


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


@dataclass(frozen=True)
class SensedMode:
    """The equations of a mode, with the amplitude that a sensor measures.

    Parameters
    ----------
    equations
        Of the mode.
    row
        Modes at the sensor, shape (linear modes,); None for the modal amplitude.
    quantity
        What it measures.
    """

    equations: EPMCEquations
    row: Array | None
    quantity: str

    def residual(self, y: Array, level: float) -> Array:
        """Residual of the mode at (x, ln a), and of ln(amplitude of the sensor) at its level."""
        residual = np.empty(y.size)
        residual[:-1] = self._residual(y[:-1], y[-1])
        residual[-1] = self.log_size(y)[0] - level
        return residual

    def factors(self, y: Array) -> LUFactors | None:
        """Factors of the Jacobian where the residual was evaluated last; None if singular."""
        matrix = np.empty((y.size, y.size))
        matrix[:-1, :-1], matrix[:-1, -1] = self._derivatives(y[:-1], y[-1])
        matrix[-1] = self.log_size(y)[1]
        return LUFactors.of(matrix)

    def factors_at(self, y: Array) -> LUFactors | None:
        """Factors of the Jacobian at (x, ln a); None if singular."""
        self._residual(y[:-1], y[-1])
        return self.factors(y)

    def log_size(self, y: Array) -> tuple[float, Array]:
        """Logarithm of the amplitude of the sensor, and its derivative by y."""
        slope = np.zeros(y.size)
        slope[-1] = 1.0
        if self.row is None:
            return float(y[-1]), slope
        sin, cos = self.equations.sin, self.equations.cos
        s, c = y[:-1][sin] @ self.row, y[:-1][cos] @ self.row
        square = s * s + c * c
        slope[:-1][sin], slope[:-1][cos] = s / square * self.row, c / square * self.row
        order, squared = MOTIONS[self.quantity], y[-3] * self.equations.scale
        slope[-3] += order / (2 * y[-3])
        return float(y[-1] + 0.5 * np.log(square) + 0.5 * order * np.log(squared)), slope

    def physical(self, y: Array) -> Array:
        """The unknown with the eigenvalue in rad2/s2, which does not depend on parameters."""
        moved = y.copy()
        moved[-3:-1] *= self.equations.scale
        return moved

    def residual_at(self, physical: Array, scale: float) -> Array:
        """Residual at an unknown with a physical eigenvalue, in terms of another scale."""
        y = physical.copy()
        y[-3:-1] /= self.equations.scale
        residual = self._residual(y[:-1], y[-1])
        residual[:-2] *= self.equations.scale / scale
        return residual

    @cached_property
    def _compiled(self) -> CompiledMode | None:
        return CompiledMode.of(self.equations)

    def _residual(self, x: Array, p: float) -> Array:
        compiled = self._compiled
        return self.equations.evaluate(x, p)[0] if compiled is None else compiled.residual(x, p)

    def _derivatives(self, x: Array, p: float) -> tuple[Array, Array]:
        """Jacobian and derivative by p where the residual was evaluated last."""
        if self._compiled is not None:
            return self._compiled.derivatives(x, p)
        _, jacobian = self.equations.evaluate(x, p)
        return jacobian(), self.equations.parameter_derivative(x, p)


@dataclass(frozen=True)
class BackbonePoints:
    """Frequency [Hz] and damping ratio at amplitudes, with derivatives.

    Attributes
    ----------
    curves
        Shape (points, 2).
    by_amplitude, by_parameter
        Derivatives by the logarithm of the amplitude, (points, 2), and by each parameter in its
        scale, (points, 2, parameters); of no points where no parameter is asked for.
    """

    curves: Array
    by_amplitude: Array
    by_parameter: Array


def solve_points(
    mode: SensedMode,
    amplitudes: Array,
    neighbours: Sequence[tuple[SensedMode, SensedMode, float]] = (),
) -> BackbonePoints:
    """The mode at ascending amplitudes of its sensor, with derivatives.

    Parameters
    ----------
    mode
        The mode.
    amplitudes
        Ascending, shape (points,).
    neighbours
        By parameter the mode with a lower and a higher value, and the difference of both in the
        scale of the parameter.

    Raises
    ------
    NotReached
        If an amplitude is not reached.
    """
    start = mode.equations.damped_start()
    y = np.append(start, 0.0)
    levels = np.log(amplitudes)
    first = levels[0] + np.log(_FIRST)
    y[-1] = first - mode.log_size(y)[0]
    corrected = _corrected(mode, y, first)
    if corrected is None:
        raise NotReached(f"no mode was found at the amplitude {np.exp(first):.3g}")
    path = _Path(mode, *corrected, first)
    curves, slopes = [], []
    for level in levels:
        if level > path.level:
            path.advance(level)
        real, imaginary = mode.physical(path.y)[-3:-1]
        w, zeta = np.sqrt(real), imaginary / (2 * real)
        curves.append((w / (2 * np.pi), zeta))
        if neighbours:
            d_real, d_imaginary = _derivatives_of_eigenvalue(mode, path.y, neighbours)
            d_frequency = d_real / (2 * w) / (2 * np.pi)
            slopes.append((d_frequency, d_imaginary / (2 * real) - zeta * d_real / real))
    derivatives = np.array(slopes).reshape(-1, 2, 1 + len(neighbours))
    return BackbonePoints(np.array(curves), derivatives[:, :, 0], derivatives[:, :, 1:])


def _derivatives_of_eigenvalue(
    mode: SensedMode, y: Array, neighbours: Sequence[tuple[SensedMode, SensedMode, float]]
) -> Array:
    """Real and imaginary part by ln(amplitude) and by each parameter, (2, 1 + parameters)."""
    right = np.zeros((y.size, 1 + len(neighbours)))
    right[-1, 0] = 1.0
    physical, scale = mode.physical(y), mode.equations.scale
    for n, (low, high, difference) in enumerate(neighbours, start=1):
        change = high.residual_at(physical, scale) - low.residual_at(physical, scale)
        right[:-1, n] = -change / difference
    factors = mode.factors_at(y)
    if factors is None:
        raise NotReached("the matrix of a mode is singular")
    return scale * factors.solve(right)[-3:-1]


class _Path:
    """The mode at one ln(amplitude) after another, each guessed from those before.

    Parameters
    ----------
    mode, y, factors, level
        The mode, its solution at a level, and factors of its matrix there.
    """

    def __init__(self, mode: SensedMode, y: Array, factors: LUFactors, level: float) -> None:
        self._mode = mode
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
            if np.linalg.norm(bend) <= _LARGEST_BEND * np.linalg.norm(step * self._tangent):
                guess += bend
            corrected = _corrected(self._mode, guess, level)
            if corrected is None:
                halvings += 1
                if halvings > _HALVINGS:
                    raise NotReached(f"no mode was found at the amplitude {np.exp(level):.3g}")
                length /= 2
                continue
            before = self._tangent
            self.y, self._factors = corrected
            self.level = level
            self._tangent = self._slope()
            self._bend = (self._tangent - before) / step

    def _slope(self) -> Array:
        """Derivative of the unknown by the level."""
        right = np.zeros_like(self.y)
        right[-1] = 1.0
        return self._factors.solve(right)


def _corrected(mode: SensedMode, y: Array, level: float) -> tuple[Array, LUFactors] | None:
    """Newton's method at a level of ln(amplitude), with factors near there; None if it fails.

    A correction with the factors of the one before is the last where it is so much smaller that
    what it leaves, which falls about as fast again, is far below the tolerance.
    """
    factors, before = None, 0.0
    for _ in range(_ITERATIONS):
        if not (np.all(np.isfinite(y)) and y[-3] > 0):
            return None
        residual = mode.residual(y, level)
        if factors is not None:
            change = factors.solve(residual)
            size = np.linalg.norm(change)
            if size**2 <= _KEPT * _TOLERANCE * np.linalg.norm(y) * before:
                return y - change, factors
        factors = mode.factors(y)
        if factors is None:
            return None
        change = factors.solve(residual)
        size = np.linalg.norm(change)
        is_whole = size <= _LARGEST
        y = y - change * (1.0 if is_whole else _LARGEST / size)
        if size <= _TOLERANCE * np.linalg.norm(y):
            return y, factors
        before = float(size) if is_whole else 0.0
    return None


def neighbours_of(
    mode_of: Callable[[Array], SensedMode], scaled: Array, bounds: tuple[Array, Array]
) -> list[tuple[SensedMode, SensedMode, float]]:
    """The mode on both sides of each parameter within its bounds, for ``solve_points``."""
    pairs = []
    for n in range(scaled.size):
        step = _STEP * max(abs(scaled[n]), 1.0)
        low, high = scaled.copy(), scaled.copy()
        # beyond its bounds a parameter may mean nothing
        low[n] = max(low[n] - step, min(bounds[0][n], low[n]))
        high[n] = min(high[n] + step, max(bounds[1][n], high[n]))
        pairs.append((mode_of(low), mode_of(high), high[n] - low[n]))
    return pairs
