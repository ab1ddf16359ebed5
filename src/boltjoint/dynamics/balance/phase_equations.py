"""Harmonic balance with the frequency as an unknown, and the phase of the output point given."""

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.output_point import OutputPoint
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.solvers.equations import Derivative, Equations

Array = NDArray[np.float64]


class PhaseEquations(Equations):
    """Harmonic balance with the frequency as unknown and the phase of the output as parameter.

    The unknown is x and, after it, ``ln w`` times the size of x; the parameter is the phase theta
    of the first harmonic ``s + i c`` of the output point, for which ``Im((s + i c) e^(-i theta))``
    vanishes.

    Parameters
    ----------
    balance
        The modal equations, in linear modes.
    scale
        Size of x.
    amplitude
        Amplitude of the output point [m], to which its deviation from the phase is compared.
    """

    def __init__(self, balance: HarmonicBalance, scale: float, amplitude: float) -> None:
        self.balance, self.output = balance, OutputPoint(balance)
        self.residual_scale = float(np.linalg.norm(balance.modal_force))
        self._size = scale
        self._weight = self.residual_scale / amplitude
        shape = len(balance.components), -1
        mode = balance.joint.response_mode
        self._sin, self._cos = (np.zeros((shape[0], mode.size)) for _ in range(2))
        self._sin[balance.components.sin()] = mode
        self._cos[balance.components.cos()] = mode

    @classmethod
    def near(
        cls, balance: HarmonicBalance, motion: PeriodicMotion, frequency: float
    ) -> tuple["PhaseEquations", Array, float]:
        """The equations near a motion at a frequency [Hz], its unknown, and its phase [rad]."""
        x, output = motion.in_components(balance.components).ravel(), OutputPoint(balance)
        equations = cls(balance, float(np.linalg.norm(x)), output.value(x))
        return equations, equations.unknown(x, 2 * np.pi * frequency), float(np.angle(output(x)))

    def unknown(self, x: Array, w: float) -> Array:
        """The unknown of a motion at a frequency [rad/s]."""
        return np.append(x, self._size * np.log(w))

    def solution(self, y: Array) -> tuple[Array, float]:
        """Motion and frequency [rad/s] of an unknown."""
        return y[:-1], float(np.exp(self.log_frequency(y)))

    def log_frequency(self, y: Array) -> float:
        """Logarithm of the frequency of an unknown, or its change in that of an unknown."""
        return float(y[-1] / self._size)

    def evaluate(self, x: Array, p: float) -> tuple[Array, Derivative]:
        """Residual and Jacobian at the phase p [rad]."""
        q, w = self.solution(x)
        residual, by_motion = self.balance.residual_and_jacobian(q, w)
        by_frequency, across = self._borders(q, w, p)

        def jacobian() -> Array:
            return _bordered(by_motion(), by_frequency, across)

        def along(dy: Array) -> Array:
            dq, dw = dy[:-1], dy[-1]
            return np.append(by_motion.along(dq) + dw * by_frequency, across @ dq)

        return np.append(residual, across @ q), Derivative(jacobian, along)

    def bordered(self, by_motion: Array, x: Array, p: float) -> Array:
        """The Jacobian at the phase p from that of the balance."""
        return _bordered(by_motion, *self._borders(*self.solution(x), p))

    def parameter_derivative(self, x: Array, p: float) -> Array:
        """Derivative of the residual by the phase."""
        along = np.sin(p) * self._cos + np.cos(p) * self._sin
        return np.append(np.zeros(x.size - 1), -self._weight * along.ravel() @ x[:-1])

    def _borders(self, q: Array, w: float, p: float) -> tuple[Array, Array]:
        """Derivatives of the balance by the last unknown, and of the last equation by the motion.

        Both have the shape of q.
        """
        across = self._weight * (np.cos(p) * self._cos - np.sin(p) * self._sin)
        return w / self._size * self.balance.frequency_derivative(q, w), across.ravel()


def _bordered(by_motion: Array, by_frequency: Array, across: Array) -> Array:
    return np.block([[by_motion, by_frequency[:, None]], [across, np.zeros(1)]])
