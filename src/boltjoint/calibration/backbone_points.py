"""Frequency and damping of a nonlinear mode at measured amplitudes, and their derivatives.

At each amplitude Newton's method solves the mode (``dynamics.backbone.epmc``) together with the
condition that its sensor has the measured amplitude. With the unknown y of this system r(y) = 0,
the implicit function theorem gives the derivatives by all parameters theta at once::

    dy/dtheta = -(dr/dy)^-1 dr/dtheta

with the matrix and derivatives of the residual at the solution.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint.calibration.level_path import LevelCurve, LevelPath, LUFactors, NotReached
from boltjoint.dynamics.backbone.compiled_epmc import CompiledMode
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.measurement.signals import MOTIONS

Array = NDArray[np.float64]

#: first amplitude over the lowest measured one, where the stuck mode is a guess
_FIRST = 1e-3


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

    def is_possible(self, y: Array) -> bool:
        """Whether the square of the frequency is positive."""
        return bool(y[-3] > 0)

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


def solve_points(
    mode: SensedMode,
    amplitudes: Array,
    neighbours: Sequence[tuple[SensedMode, SensedMode, float]] = (),
) -> LevelCurve:
    """Frequency [Hz] and damping ratio of a mode at ascending amplitudes of its sensor.

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
    path = LevelPath(mode, y, first)
    curves, slopes = [], []
    for level in levels:
        if level > path.level:
            path.advance(level)
        real, imaginary = mode.physical(path.y)[-3:-1]
        w, zeta = np.sqrt(real), imaginary / (2 * real)
        curves.append(np.array([w / (2 * np.pi), zeta]))
        if neighbours:
            d_real, d_imaginary = _derivatives_of_eigenvalue(mode, path.y, neighbours)
            d_frequency = d_real / (2 * w) / (2 * np.pi)
            d_damping = d_imaginary / (2 * real) - zeta * d_real / real
            slopes.append(np.array([d_frequency, d_damping]))
    return LevelCurve.of(curves, slopes)


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
