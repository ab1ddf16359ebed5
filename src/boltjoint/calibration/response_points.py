"""Excitation that forces a measured motion, and its derivatives by parameters.

At a measured frequency the sensor is held at its measured amplitude, and the excitation that this
needs is unknown. Unlike the amplitude under a given force, which has several values between folds,
there is one::

    (L + i H - w^2) phi + f(a phi) / a = g E,   row . phi = |row|

with the modes L, damping H and contact force f of a joint, a phi its motion, E its excitation of
level 1 and a g the level with its phase. Derivatives are those of the implicit function theorem, as
in ``backbone_points``.
"""

from collections.abc import Sequence
from functools import partial

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
    corrected,
)
from boltjoint.dynamics.balance.compiled_balance import CompiledBalance
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.harmonics import Components
from boltjoint.measurement.signals import MOTIONS
from boltjoint.solvers.equations import LazyJacobian

Array = NDArray[np.float64]

#: first amplitude over the measured one, where the response without slip is a guess
_FIRST = 1e-3


class ForcedBalance:
    """A balance under an excitation of any level and phase.

    Parameters
    ----------
    balance
        Of a joint under an excitation of level 1.
    """

    def __init__(self, balance: HarmonicBalance) -> None:
        self.balance, self._solved = balance, CompiledBalance.of(balance) or balance
        #: excitation of level 1, and the same a quarter of a period later, (unknowns, 2)
        self.excitation = np.column_stack([balance.modal_force, self.later(balance.modal_force)])

    def later(self, x: Array) -> Array:
        """A motion a quarter of a period later."""
        return self.balance.components.later(x).ravel()

    def evaluate(self, y: Array, w: float) -> tuple[Array, Array, LazyJacobian]:
        """At the unknown of a ``SensedMotion``, and a frequency [rad/s].

        Returns
        -------
        tuple
            The residual without what the sensor asks for; the forces that the excitation has to
            balance; and their derivative by the motion, until the next evaluation.
        """
        a = np.exp(y[-1])
        excited, stiffness = self._solved.residual_and_jacobian(a * y[:-3], w)
        return *self._residual(excited, y, a * w**2), stiffness

    def residuals(self, y: Array, w: Array) -> Array:
        """The first of what ``evaluate`` returns, at several unknowns and their frequencies.

        Of y (points, unknowns) and w (points,) [rad/s], shape (points, unknowns - 3).
        """
        a = np.exp(y[:, -1:])
        motions = a * y[:, :-3]
        if isinstance(self._solved, CompiledBalance):
            excited = self._solved.residuals(motions, w)
        else:
            excited = np.array([self.balance.residual(*at) for at in zip(motions, w, strict=True)])
        return self._residual(excited, y, a * w[:, None] ** 2)[0]

    def _residual(self, excited: Array, y: Array, scale: Array | float) -> tuple[Array, Array]:
        """What ``evaluate`` returns first, and forces, of balances at some unknowns."""
        forces = excited + self.balance.modal_force
        return forces / scale - y[..., -3:-1] @ self.excitation.T, forces


class SensedMotion:
    """The equations of a motion at one frequency, with the amplitude that a sensor measures.

    The unknown holds phi, real and imaginary part of g over the square of the frequency, and ln a.

    Parameters
    ----------
    forced
        The joint and its excitation.
    row
        Modes at the sensor, shape (linear modes,).
    quantity
        What it measures.
    w
        Frequency [rad/s].
    """

    def __init__(self, forced: ForcedBalance, row: Array, quantity: str, w: float) -> None:
        self.w = w
        self._forced, self._row, self._order = forced, row, MOTIONS[quantity]
        self._components = forced.balance.components
        self._length = float(np.linalg.norm(row))
        #: what the excitation has to balance where the residual was evaluated last, and derivative
        self._forces = np.zeros(0)
        self._stiffness: LazyJacobian = lambda: np.zeros((0, 0))

    def level(self, amplitude: float) -> float:
        """Logarithm of a for an amplitude of the sensor."""
        return float(np.log(amplitude / self.w**self._order / self._length))

    def stuck(self, level: float) -> Array:
        """The motion without slip.

        Raises
        ------
        NotReached
            If the excitation does not move the sensor.
        """
        response = self._forced.balance.stuck_solution(self.w)
        s, c = _at_sensor(self._components, response, self._row)
        square = s * s + c * c
        if square <= 0:
            raise NotReached("the excitation does not move the sensor")
        # the response times a complex number, of which that of the sensor becomes real
        real, imaginary = self._length / square * np.array([s, -c])
        phi = real * response + imaginary * self._forced.later(response)
        return np.append(phi, [real / self.w**2, imaginary / self.w**2, level])

    def residual(self, y: Array, level: float) -> Array:
        """Residual at an unknown; the last entry is that of the level."""
        residual = np.empty(y.size)
        residual[:-3], self._forces, self._stiffness = self._forced.evaluate(y, self.w)
        s, c = _at_sensor(self._components, y[:-3], self._row)
        residual[-3:] = s - self._length, c, y[-1] - level
        return residual

    def factors(self, y: Array) -> LUFactors | None:
        """Factors of the Jacobian where the residual was evaluated last; None if singular."""
        phi, a, n = y[:-3], np.exp(y[-1]), y.size - 3
        stiffness = self._stiffness()
        matrix = np.zeros((y.size, y.size))
        matrix[:n, :n] = stiffness / self.w**2
        matrix[:n, n : n + 2] = -self._forced.excitation
        matrix[:n, -1] = (stiffness @ phi - self._forces / a) / self.w**2
        places = self._components.rows(np.arange(n))
        matrix[n, places[self._components.sin()]] = self._row
        matrix[n + 1, places[self._components.cos()]] = self._row
        matrix[-1, -1] = 1.0
        return LUFactors.of(matrix)

    def is_possible(self, _: Array) -> bool:
        """Any unknown may be that of a motion."""
        return True

    def excitation(self, y: Array) -> tuple[Array, Array]:
        """Logarithm of the excitation, and phase of the response from it [rad].

        Returns
        -------
        values : ndarray
            Both, (2,).
        derivatives : ndarray
            By the two parts of g and by ln a, (2, 3).
        """
        real, imaginary, log_a = y[-3:]
        square = real**2 + imaginary**2
        size = 0.5 * np.log(square) + 2 * np.log(self.w) + log_a
        phase = self._order * np.pi / 2 - np.arctan2(imaginary, real)
        by_size = [real / square, imaginary / square, 1.0]
        by_phase = [imaginary / square, -real / square, 0.0]
        return np.array([size, phase]), np.array([by_size, by_phase])


def solve_motions(
    balance: HarmonicBalance,
    row: Array,
    quantity: str,
    frequency: Array,
    amplitude: Array,
    neighbours: Sequence[Neighbours] = (),
) -> LevelCurve:
    """Logarithm of the excitation of measured motions and phase of these from it [rad].

    Parameters
    ----------
    balance, row, quantity
        As of ``SensedMotion``.
    frequency
        Of each point [Hz], shape (points,): neighbours help to solve each other.
    amplitude
        Of the sensor [SI unit of its quantity], (points,).
    neighbours
        Of each parameter, of balances under an excitation of level 1.

    Raises
    ------
    NotReached
        If a motion is not found.
    """
    forced, w, y = ForcedBalance(balance), 2 * np.pi * frequency, None
    motions = [SensedMotion(forced, row, quantity, each) for each in w.tolist()]
    solved = []
    for motion, a in zip(motions, amplitude, strict=True):
        y = _solved(motion, motion.level(a), y)
        solved.append(y)
    excitations = [motion.excitation(y) for motion, y in zip(motions, solved, strict=True)]
    values = np.array([value for value, _ in excitations])
    if not neighbours:
        return LevelCurve.of(values, None)
    unknowns = np.array(solved)
    right = change_by_parameters(partial(_residuals, motions, unknowns), neighbours, unknowns)
    slopes = [
        by_unknown @ _factors_at(motion, y).solve(sides)[-3:]
        for motion, y, sides, (_, by_unknown) in zip(
            motions, unknowns, right, excitations, strict=True
        )
    ]
    return LevelCurve.of(values, np.array(slopes))


def _residuals(motions: Sequence[SensedMotion], unknowns: Array, other: SensedBalance) -> Array:
    """Residuals of another balance and its sensor at amplitude 1, (points, unknowns)."""
    w, row = np.array([motion.w for motion in motions]), other.row
    assert row is not None  # a response has a sensor
    residuals = np.empty_like(unknowns)
    residuals[:, :-3] = ForcedBalance(other.balance).residuals(unknowns, w)
    s, c = _at_sensor(other.balance.components, unknowns[:, :-3], row)
    length = np.linalg.norm(row)
    residuals[:, -3:] = np.column_stack([s - length, c, unknowns[:, -1] + np.log(length)])
    return residuals


def _at_sensor(components: Components, x: Array, row: Array) -> tuple[Array, Array]:
    """Sine and cosine of a sensor in motions x (..., unknowns)."""
    moved = x.reshape(*x.shape[:-1], len(components), -1) @ row
    return moved[..., components.sin()], moved[..., components.cos()]


def _solved(motion: SensedMotion, level: float, near: Array | None) -> Array:
    """The motion at a level, from one nearby or that without slip."""
    if near is not None and (found := corrected(motion, near, level)) is not None:
        return found[0]
    first = level + np.log(_FIRST)
    path = LevelPath(motion, motion.stuck(first), first)
    path.advance(level)
    return path.y


def _factors_at(motion: SensedMotion, y: Array) -> LUFactors:
    motion.residual(y, y[-1])
    factors = motion.factors(y)
    if factors is None:
        raise NotReached(f"the matrix of a motion at {motion.w / (2 * np.pi):.4g} Hz is singular")
    return factors
