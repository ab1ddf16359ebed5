"""Frequency and damping of a nonlinear mode at measured amplitudes, and their derivatives.

At each amplitude Newton's method solves the mode (``dynamics.backbone.epmc``) together with the
condition that its sensor has the measured amplitude. With the unknown y of this system r(y) = 0,
the implicit function theorem gives the derivatives by all parameters theta at once::

    dy/dtheta = -(dr/dy)^-1 dr/dtheta

with the matrix that Newton's method has, and derivatives of the residual alone at the solution.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.backbone.compiled_epmc import CompiledMode
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.measurement.signals import MOTIONS

Array = NDArray[np.float64]

#: iterations of Newton's method, and relative change of the unknown at which it ends
_ITERATIONS, _TOLERANCE = 12, 1e-9

#: how far the correction of a step may lead, and how often a step in amplitude is halved
_LARGEST, _HALVINGS = 0.5, 10

#: first amplitude over the lowest measured one, where the stuck mode is a guess
_FIRST = 1e-3

#: step of central differences of the residual: their error, its square, is as small as rounding
_STEP = 1e-6


class NotReached(ValueError):
    """A mode that was not found at a measured amplitude."""


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

    def system(self, y: Array) -> tuple[Array, Array]:
        """Residual and Jacobian of mode and ln(amplitude of the sensor), by (x, ln a)."""
        x, p = y[:-1], y[-1]
        residual = self._residual(x, p)
        matrix = np.zeros((y.size, y.size))
        matrix[:-1, :-1], matrix[:-1, -1] = self._derivatives(x, p)
        size, slope = self.log_size(y)
        matrix[-1] = slope
        return np.append(residual, size), matrix

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
    by_amplitude
        Derivative by the logarithm of the amplitude, (points, 2).
    by_parameter
        Derivative by each parameter in its scale, (points, 2, parameters).
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
    solution, matrix = _corrected(mode, y, first)
    if solution is None:
        raise NotReached(f"no mode was found at the amplitude {np.exp(first):.3g}")
    y, slope = solution, _by_amplitude(matrix)
    curves, by_amplitude, by_parameter = [], [], []
    at = first
    for level in levels:
        if level > at:
            y, matrix = _step(mode, y, slope[:, 0], at, level)
            at = level
        right = np.zeros((y.size, 1 + len(neighbours)))
        right[-1, 0] = 1.0
        physical = mode.physical(y)
        scale = mode.equations.scale
        for n, (low, high, difference) in enumerate(neighbours, start=1):
            change = high.residual_at(physical, scale) - low.residual_at(physical, scale)
            right[:-1, n] = -change / difference
        slope = _solved(matrix, right)
        real, imaginary = physical[-3:-1]
        w, zeta = np.sqrt(real), imaginary / (2 * real)
        d_real, d_imaginary = mode.equations.scale * slope[-3:-1]
        d_frequency = d_real / (2 * w) / (2 * np.pi)
        d_damping = d_imaginary / (2 * real) - zeta * d_real / real
        curves.append((w / (2 * np.pi), zeta))
        by_amplitude.append((d_frequency[0], d_damping[0]))
        by_parameter.append((d_frequency[1:], d_damping[1:]))
    shape = len(levels), 2, len(neighbours)
    return BackbonePoints(
        np.array(curves), np.array(by_amplitude), np.array(by_parameter).reshape(shape)
    )


def _step(
    mode: SensedMode, y: Array, tangent: Array, begin: float, end: float
) -> tuple[Array, Array]:
    """The mode from one ln(amplitude) to another, in as many steps as it needs, and its matrix."""
    at, length, halvings = begin, end - begin, 0
    while True:
        target = end if at + length >= end - 1e-12 else at + length
        guess = y + (target - at) * tangent
        corrected, matrix = _corrected(mode, guess, target)
        if corrected is None:
            halvings += 1
            if halvings > _HALVINGS:
                raise NotReached(f"no mode was found at the amplitude {np.exp(target):.3g}")
            length /= 2
            continue
        if target == end:
            return corrected, matrix
        y, at, tangent = corrected, target, _by_amplitude(matrix)[:, 0]


def _by_amplitude(matrix: Array) -> Array:
    """Derivative of the unknown by ln(amplitude), (unknowns, 1)."""
    right = np.zeros((len(matrix), 1))
    right[-1] = 1.0
    return _solved(matrix, right)


def _solved(matrix: Array, right: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(matrix, right), float)
    except np.linalg.LinAlgError:
        raise NotReached("the matrix of a mode is singular") from None


def _corrected(mode: SensedMode, y: Array, level: float) -> tuple[Array | None, Array]:
    """Newton's method at a level of ln(amplitude); None where it does not converge."""
    matrix = np.zeros((0, 0))
    for _ in range(_ITERATIONS):
        if not (np.all(np.isfinite(y)) and y[-3] > 0):
            return None, matrix
        residual, matrix = mode.system(y)
        residual[-1] -= level
        try:
            change = np.linalg.solve(matrix, residual)
        except np.linalg.LinAlgError:
            return None, matrix
        size = np.linalg.norm(change)
        y = y - change * (1.0 if size <= _LARGEST else _LARGEST / size)
        if size <= _TOLERANCE * np.linalg.norm(y):
            # a last correction so small has an error of its square, and leaves the matrix as it is
            return y, matrix
    return None, matrix


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
