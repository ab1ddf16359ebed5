"""How far an error of a backbone's eigenvalue moves the peak of the response there."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.backbone.epmc import ModalState

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PeakSensitivity:
    """Derivatives of a peak by the eigenvalue ``lambda = w^2 (1 + 2 i zeta)`` at its amplitude.

    The response to a force F has its peak where the force of the damping balances it,
    ``F ~ a Im(lambda)``. An error of Im(lambda) at an amplitude therefore moves the amplitude at a
    force by itself over ``growth``, the derivative of ln F by ln a, and with it the frequency.

    Attributes
    ----------
    eigenvalue
        lambda, real and imaginary part, shape (2,).
    growth
        d ln F / d ln a; where it vanishes, peaks have a fold over the force.
    stiffening
        d ln Re(lambda) / d ln a.
    """

    eigenvalue: Array
    growth: float
    stiffening: float

    @property
    def gradient(self) -> Array:
        """Of the relative frequency, then amplitude, by both parts of lambda, shape (2, 2)."""
        real, imaginary = self.eigenvalue
        amplitude = np.array([0.0, -1.0 / (self.growth * imaginary)])
        frequency = np.array([0.5 / real, 0.0]) + 0.5 * self.stiffening * amplitude
        return np.stack([frequency, amplitude])


def peak_sensitivities(
    states: Sequence[ModalState], smallest_growth: float
) -> tuple[PeakSensitivity, ...]:
    """The sensitivity of the peak at each state of a backbone, at least three.

    Parameters
    ----------
    states
        In the order of the amplitude.
    smallest_growth
        Size of d ln F / d ln a below which it counts as this: where peaks have a fold over the
        force no model gives them the same force.
    """
    p = np.array([state.log_amplitude for state in states])
    eigenvalue = np.array([[s.eigenvalue.real, s.eigenvalue.imag] for s in states])
    stiffening, damping = np.gradient(np.log(np.abs(eigenvalue)), p, axis=0).T
    growth = 1 + damping
    limited = np.where(growth < 0, -1.0, 1.0) * np.maximum(abs(growth), smallest_growth)
    return tuple(map(PeakSensitivity, eigenvalue, limited, stiffening))
