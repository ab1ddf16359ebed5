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
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
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
        if self.row is None:
            return float(y[-1])
        s, c = self._moved(y, self.row)
        order, squared = MOTIONS[self.quantity], y[-3] * self.equations.scale
        return float(y[-1] + 0.5 * np.log(s * s + c * c) + 0.5 * order * np.log(squared))

    def _slope_of_log_size(self, y: Array) -> Array:
        """Its derivative by y."""
        slope = np.zeros(y.size)
        slope[-1] = 1.0
        if self.row is not None:
            s, c = self._moved(y, self.row)
            square = s * s + c * c
            slope[self.equations.sin] = s / square * self.row
            slope[self.equations.cos] = c / square * self.row
            slope[-3] += MOTIONS[self.quantity] / (2 * y[-3])
        return slope

    def _moved(self, y: Array, row: Array) -> tuple[float, float]:
        """Sine and cosine of the sensor in the mode."""
        return float(y[self.equations.sin] @ row), float(y[self.equations.cos] @ row)

    def residuals(self, unknowns: Array, balance: HarmonicBalance) -> Array:
        """Residual of the mode of another balance, at several unknowns (motions, unknowns)."""
        compiled = CompiledMode.of(balance, self.equations.scale)
        if compiled is not None:
            return compiled.residuals(unknowns)
        equations = self.equations.with_balance(balance)
        return np.array([equations.evaluate(y[:-1], y[-1])[0] for y in unknowns])

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
    neighbours: Sequence[tuple[HarmonicBalance, HarmonicBalance, float]] = (),
) -> LevelCurve:
    """Frequency [Hz] and damping ratio of a mode at ascending amplitudes of its sensor.

    Parameters
    ----------
    mode
        The mode.
    amplitudes
        Ascending, shape (points,).
    neighbours
        By parameter the balance with a lower and a higher value, and the difference of both in the
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
    y[-1] = first - mode.log_size(y)
    path = LevelPath(mode, y, first)
    solved = np.empty((levels.size, y.size))
    for point, level in enumerate(levels):
        if level > path.level:
            path.advance(level)
        solved[point] = path.y
    real, imaginary = mode.equations.scale * solved[:, -3:-1].T
    w, zeta = np.sqrt(real), imaginary / (2 * real)
    curves = [*np.column_stack([w / (2 * np.pi), zeta])]
    if not neighbours:
        return LevelCurve.of(curves, ())
    d_real, d_imaginary = _derivatives_of_eigenvalue(mode, solved, neighbours)
    d_frequency = d_real / (2 * w[:, None]) / (2 * np.pi)
    d_damping = d_imaginary / (2 * real[:, None]) - (zeta / real)[:, None] * d_real
    return LevelCurve.of(curves, [*np.stack([d_frequency, d_damping], axis=1)])


def _derivatives_of_eigenvalue(
    mode: SensedMode,
    solved: Array,
    neighbours: Sequence[tuple[HarmonicBalance, HarmonicBalance, float]],
) -> tuple[Array, Array]:
    """Real and imaginary part by ln(amplitude) and by each parameter, (points, 1 + parameters)."""
    points, unknowns = solved.shape
    right = np.zeros((points, unknowns, 1 + len(neighbours)))
    right[:, -1, 0] = 1.0
    for n, (low, high, difference) in enumerate(neighbours, start=1):
        # what is no parameter of the joint changes nothing
        if not (low.joint is high.joint and low.damping is high.damping):
            change = mode.residuals(solved, low) - mode.residuals(solved, high)
            right[:, :-1, n] = change / difference
    derivatives = np.empty((2, points, 1 + len(neighbours)))
    for point, y in enumerate(solved):
        factors = mode.factors_at(y)
        if factors is None:
            raise NotReached("the matrix of a mode is singular")
        derivatives[:, point] = factors.solve(right[point])[-3:-1]
    return tuple(mode.equations.scale * derivatives)
