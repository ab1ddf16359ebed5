"""The harmonic balance as equations of the solvers, over the frequency or over the phase.

Over the frequency the unknown is the motion in all linear modes, those of the structure without
contact. Over the phase of the output point the frequency is an unknown too.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: section 2.1.2, eq. 2.38.
"""

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.balance.compiled_balance import balance_system
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance, OutputPoint
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.solvers.compiled_steps import System
from boltjoint.solvers.equations import Derivative, Equations, LazyJacobian, Precision

Jacobian = Literal["analytic", "forward-difference"]

#: step of forward differences over the size of the unknown: the square root of rounding
_DIFFERENCE = float(np.sqrt(np.finfo(float).eps))


class BalanceEquations(Equations):
    """The harmonic balance as equations of the solvers, with all linear modes as coordinates.

    Parameters
    ----------
    balance
        The modal equations.
    jacobian
        ``analytic``, or ``forward-difference`` as in eq. 2.38.

    Raises
    ------
    ValueError
        If the kind of Jacobian is not known.
    """

    def __init__(self, balance: HarmonicBalance, jacobian: Jacobian = "analytic") -> None:
        checks.instance("balance", balance, HarmonicBalance)
        checks.choice("jacobian", jacobian, get_args(Jacobian))
        self.balance = balance
        self.residual_scale = float(np.linalg.norm(balance.modal_force))
        self.is_analytic = jacobian == "analytic"

    def compiled_system(self) -> System | None:
        """The equations as compiled loops follow them; None where the general ones are needed."""
        return balance_system(self.balance) if self.is_analytic else None

    def in_all_modes(self, reduced: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Solutions that no basis held or predicted, by whether one did."""
        return ~reduced

    def evaluate(
        self, x: NDArray[np.float64], p: float, load_factor: float = 1.0
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and Jacobian at the frequency p [rad/s], under a part of the excitation."""
        residual, jacobian = (
            self.balance.residual_and_jacobian(x, p)
            if self.is_analytic
            else self._with_differences(x, p)
        )
        return residual + (1 - load_factor) * self.balance.modal_force, jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        return self.balance.frequency_derivative(x, p)

    def load_factor_derivative(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of the residual by the load factor."""
        return -self.balance.modal_force

    def _residual(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Residual under the whole excitation."""
        return self.balance.residual(x, p)

    def _with_differences(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        residual = self._residual(x, p)

        def jacobian() -> NDArray[np.float64]:
            columns = np.empty((x.size, x.size))
            size = np.linalg.norm(x) / np.sqrt(x.size) or 1.0
            for j in range(x.size):
                step = _DIFFERENCE * max(abs(x[j]), size)
                moved = x.copy()
                moved[j] += step
                columns[:, j] = (self._residual(moved, p) - residual) / (moved[j] - x[j])
            return columns

        return residual, jacobian


Array = NDArray[np.float64]


class PhaseEquations(Equations):
    """Harmonic balance with the frequency as unknown and the phase of the output as parameter.

    Time is shifted so that the first harmonic of the output point is a sine, and the excitation
    lags behind it by -theta, minus the parameter: friction does not see where time begins, so that
    motions hardly change with theta. In the time of the excitation their harmonic h turns by
    h theta: residuals of motions guessed from others 0.03 rad away were fifty times the force.
    The unknown is x and, after it, ``ln w`` times the size of x.

    Parameters
    ----------
    balance
        The modal equations, in linear modes.
    scale
        Size of x.
    amplitude
        Amplitude of the output point [m], to which its deviation from the phase is compared.
    begin
        Phase of the output point at the first sample of friction [rad].
    """

    def __init__(
        self, balance: HarmonicBalance, scale: float, amplitude: float, begin: float = 0.0
    ) -> None:
        self.balance, self.output = balance, OutputPoint(balance)
        self.residual_scale = float(np.linalg.norm(balance.modal_force))
        self._size, self._amplitude, self._begin = scale, amplitude, begin
        across = np.zeros((len(balance.components), balance.joint.response_mode.size))
        across[balance.components.cos()] = balance.joint.response_mode
        across = balance.components.turned(across, begin)
        self._across = self.residual_scale / amplitude * across.ravel()

    @classmethod
    def near(
        cls, balance: HarmonicBalance, motion: PeriodicMotion, frequency: float
    ) -> tuple["PhaseEquations", Array, float]:
        """The equations near a motion at a frequency [Hz], its unknown, and its phase [rad]."""
        x, output = motion.in_components(balance.components).ravel(), OutputPoint(balance)
        equations = cls(balance, float(np.linalg.norm(x)), output.value(x))
        phase = float(np.angle(output(x)))
        x = balance.components.turned(x, -phase).ravel()
        return equations, equations.unknown(x, 2 * np.pi * frequency), phase

    def beginning_at(self, y: Array, begin: float) -> tuple["PhaseEquations", Array]:
        """The equations whose time begins at another phase [rad], and an unknown in that time."""
        equations = PhaseEquations(self.balance, self._size, self._amplitude, begin)
        turned = self.balance.components.turned(y[:-1], begin - self._begin)
        return equations, np.append(turned, y[-1])

    def of_fewer(self, fewer: "PhaseEquations", y: Array) -> Array:
        """The unknown from that of equations with fewer harmonics, in the time of both."""
        q, w = fewer.solution(y)
        return self.unknown(np.append(q, np.zeros(self.balance.modal_force.size - q.size)), w)

    def unknown(self, x: Array, w: float) -> Array:
        """The unknown of a motion in the time of the output point at a frequency [rad/s]."""
        return np.append(x, self._size * np.log(w))

    def solution(self, y: Array) -> tuple[Array, float]:
        """Motion in the time of the output point and frequency [rad/s] of an unknown."""
        return y[:-1], float(np.exp(self.log_frequency(y)))

    def motion(self, y: Array, phase: float) -> tuple[PeriodicMotion, float]:
        """Motion in the time of the excitation, and its frequency [Hz]."""
        (q, w), components = self.solution(y), self.balance.components
        motion = PeriodicMotion(components, components.turned(q, phase - self._begin))
        return motion, w / (2 * np.pi)

    def log_frequency(self, y: Array) -> float:
        """Logarithm of the frequency of an unknown, or its change in that of an unknown."""
        return float(y[-1] / self._size)

    def evaluate(self, x: Array, p: float) -> tuple[Array, Derivative]:
        """Residual and Jacobian at the phase p [rad]."""
        q, w = self.solution(x)
        residual, by_motion = self.balance.residual_and_jacobian(q, w)
        residual += self.balance.modal_force - self._force(p)
        by_frequency = self._by_frequency(q, w)

        def jacobian(precision: Precision) -> Array:
            return _bordered(by_motion(precision), by_frequency, self._across)

        def along(dy: Array) -> Array:
            dq, dw = dy[:-1], dy[-1]
            return np.append(by_motion.along(dq) + dw * by_frequency, self._across @ dq)

        return np.append(residual, self._across @ q), Derivative(jacobian, along)

    def parameter_derivative(self, x: Array, p: float) -> Array:
        """Derivative of the residual by the phase."""
        # a quarter of a period later the force has its own derivative
        return np.append(self._force(p - np.pi / 2), 0.0)

    def _force(self, phase: float) -> Array:
        """Excitation in modal coordinates with the phase of the output point, shape of q."""
        force = self.balance.modal_force
        return self.balance.components.turned(force, self._begin - phase).ravel()

    def _by_frequency(self, q: Array, w: float) -> Array:
        """Derivative of the balance by the last unknown, shape of q."""
        return w / self._size * self.balance.frequency_derivative(q, w)


def _bordered(by_motion: Array, by_frequency: Array, across: Array) -> Array:
    bordered = np.zeros((across.size + 1,) * 2, by_motion.dtype)
    bordered[:-1, :-1], bordered[:-1, -1], bordered[-1, :-1] = by_motion, by_frequency, across
    return bordered
