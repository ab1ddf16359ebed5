"""Frequency and damping of a nonlinear mode at measured amplitudes, and their derivatives.

At each amplitude Newton's method solves the mode (``dynamics.backbone.epmc``) together with the
condition that its sensor has the measured amplitude. With the unknown y of this system r(y) = 0,
the implicit function theorem gives the derivatives by all parameters theta at once::

    dy/dtheta = -(dr/dy)^-1 dr/dtheta

with the matrix and derivatives of the residual at the solution.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from boltjoint.calibration.level_path import (
    LevelCurve,
    LevelPath,
    LUFactors,
    Neighbours,
    NotReached,
    SensedBalance,
    change_by_parameters,
)
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
        residual[-1] = self.log_size(y) - level
        return residual

    def factors(self, y: Array) -> LUFactors | None:
        """Factors of the Jacobian where the residual was evaluated last; None if singular."""
        matrix = np.empty((y.size, y.size))
        matrix[:-1, :-1], matrix[:-1, -1] = self._derivatives(y[:-1], y[-1])
        matrix[-1] = self._slope_of_log_size(y)
        return LUFactors.of(matrix)

    def is_possible(self, y: Array) -> bool:
        """Whether the square of the frequency is positive."""
        return bool(y[-3] > 0)

    def factors_at(self, y: Array) -> LUFactors | None:
        """Factors of the Jacobian at (x, ln a); None if singular."""
        self._residual(y[:-1], y[-1])
        return self.factors(y)

    def log_size(self, y: Array) -> float:
        """Logarithm of the amplitude of the sensor."""
        return float(self._log_size(y, self.row))

    def _log_size(self, y: Array, row: Array | None) -> Array:
        """That of a sensor at each of some unknowns, (..., unknowns)."""
        if row is None:
            return y[..., -1]
        s, c = self._moved(y, row)
        order, squared = MOTIONS[self.quantity], y[..., -3] * self.equations.scale
        return y[..., -1] + 0.5 * np.log(s * s + c * c) + 0.5 * order * np.log(squared)

    def _slope_of_log_size(self, y: Array) -> Array:
        """Derivative of ``log_size`` by y, shape (unknowns,)."""
        slope = np.zeros(y.size)
        slope[-1] = 1.0
        if self.row is not None:
            s, c = self._moved(y, self.row)
            square = s * s + c * c
            slope[self.equations.sin] = s / square * self.row
            slope[self.equations.cos] = c / square * self.row
            slope[-3] += MOTIONS[self.quantity] / (2 * y[-3])
        return slope

    def _moved(self, y: Array, row: Array) -> tuple[Array, Array]:
        """Sine and cosine of a sensor in the mode at each of some unknowns."""
        return y[..., self.equations.sin] @ row, y[..., self.equations.cos] @ row

    def residuals(self, unknowns: Array, other: SensedBalance) -> Array:
        """Residual of the mode of another balance and its sensor at level 0, at several unknowns.

        Both of shape (points, unknowns), with ln a last; the balance is without excitation.
        """
        compiled = CompiledMode.of(other.balance, self.equations.scale)
        equations = compiled or self.equations.with_balance(other.balance)
        sizes = self._log_size(unknowns, other.row)
        return np.column_stack([equations.residuals(unknowns), sizes])

    @cached_property
    def _compiled(self) -> CompiledMode | None:
        return CompiledMode.of(self.equations.balance, self.equations.scale)

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
    neighbours: Sequence[Neighbours] = (),
) -> LevelCurve:
    """Frequency [Hz] and damping ratio of a mode at ascending amplitudes of its sensor.

    Parameters
    ----------
    mode
        The mode.
    amplitudes
        Ascending, shape (points,).
    neighbours
        Of each parameter, of balances without excitation.

    Raises
    ------
    NotReached
        If an amplitude is not reached.
    """
    start = mode.equations.damped_start()
    y = np.append(start, 0.0)
    levels = np.log(amplitudes)
    first = levels[0] + np.log(_FIRST)
    y[-1] = first - mode.log_size(y)
    path = LevelPath(mode, y, first)
    solved = np.empty((levels.size, y.size))
    for point, level in enumerate(levels):
        if level > path.level:
            path.advance(level)
        solved[point] = path.y
    real, imaginary = mode.equations.scale * solved[:, -3:-1].T
    w, zeta = np.sqrt(real), imaginary / (2 * real)
    values = np.column_stack([w / (2 * np.pi), zeta])
    if not neighbours:
        return LevelCurve.of(values, None)
    right = change_by_parameters(partial(mode.residuals, solved), neighbours, solved)
    slopes = np.empty((levels.size, 2, right.shape[2]))
    for slope, y, sides in zip(slopes, solved, right, strict=True):
        factors = mode.factors_at(y)
        if factors is None:
            raise NotReached("the matrix of a mode is singular")
        slope[:] = mode.equations.scale * factors.solve(sides)[-3:-1]
    d_real, d_imaginary = slopes[:, 0], slopes[:, 1]
    d_frequency = d_real / (2 * w[:, None]) / (2 * np.pi)
    d_damping = d_imaginary / (2 * real[:, None]) - (zeta / real)[:, None] * d_real
    return LevelCurve.of(values, np.stack([d_frequency, d_damping], axis=1))
