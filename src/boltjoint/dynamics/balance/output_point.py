"""Amplitude of the output point."""

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance


class OutputPoint:
    """Complex first-harmonic amplitude of the output point [m] from modal coordinates.

    Parameters
    ----------
    balance
        The modal equations, in linear modes.
    """

    def __init__(self, balance: HarmonicBalance) -> None:
        self._mode = balance.joint.sensors.output
        self._sin, self._cos = balance.components.sin(), balance.components.cos()

    def __call__(self, q: NDArray[np.float64]) -> complex:
        """Complex amplitude, sine coefficient + i cosine coefficient [m]."""
        amplitude = q.reshape(-1, self._mode.size) @ self._mode
        return complex(amplitude[self._sin], amplitude[self._cos])

    def value(self, q: NDArray[np.float64]) -> float:
        """Amplitude [m]."""
        return abs(self(q))

    def amplitudes(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Amplitudes [m] of several solutions, shape (solutions, components * modes)."""
        if not len(q):
            return np.zeros(0)
        at = q.reshape(len(q), -1, self._mode.size) @ self._mode
        return np.hypot(at[:, self._sin], at[:, self._cos])

    def slope(self, q: NDArray[np.float64], dq: NDArray[np.float64]) -> float:
        """Half the derivative of the square of the amplitude, of the same sign as its own."""
        return float((self(q).conjugate() * self(dq)).real)
