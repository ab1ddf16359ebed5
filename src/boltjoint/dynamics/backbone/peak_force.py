"""The excitation whose response has its peak at a state of a backbone: isolated branches, errors.

A response to the excitation F reaches those amplitudes a of the backbone whose peak needs no more,
``F(a) <= F``: they are one interval where F(a) rises. Where it falls and rises again, an excitation
between the lowest and the highest there has several: the first belongs to the branch that
continuation from low frequencies follows, each further one to a closed branch (isola) of its own.
By the same F(a) an error of the eigenvalue of a state moves the peak.

References
----------
R. J. Kuether, L. Renson, T. Detroux, C. Grappasonni, G. Kerschen, M. S. Allen: Nonlinear normal
modes, modal interactions and isolated resonance curves. Journal of Sound and Vibration 351 (2015)
299-310.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.backbone.epmc import ModalState

#: a smaller relative fall of the excitation between states is within the tolerance of their modes
_ROUNDING = 1e-6


class IsolatedBranches(NamedTuple):
    """Excitations with isolated branches, shape (ranges,).

    Between ``lowest`` and ``highest`` there is one or more; they appear at the state ``first``.
    """

    lowest: NDArray[np.float64]
    highest: NDArray[np.float64]
    first: NDArray[np.int64]

    def variables(
        self, amplitude: NDArray[np.float64], unit: str
    ) -> tuple[tuple[str, str, NDArray[np.float64], str, str], ...]:
        """Variables of ``backbone.nc`` by the response amplitude of its states [m]."""
        at = amplitude[self.first]
        return (
            ("isolated_from", "isola", self.lowest, unit, "lowest excitation with isolated branch"),
            ("isolated_to", "isola", self.highest, unit, "highest excitation with that branch"),
            ("isolated_amplitude", "isola", at, "m", "response_amplitude where the branch appears"),
        )


def find_isolated_branches(force: NDArray[np.float64]) -> IsolatedBranches:
    """Excitations that reach several intervals of amplitudes of a backbone.

    Parameters
    ----------
    force
        Excitation whose response has its peak at each state, in the order of rising amplitude,
        shape (states,).

    Raises
    ------
    ValueError
        If an excitation is not finite.
    """
    force = checks.array("force", force, ("states",))
    highest = np.maximum.accumulate(force)
    below = force < highest * (1 - _ROUNDING)
    edges = np.flatnonzero(np.diff(below, prepend=False, append=False))
    runs = edges.reshape(-1, 2)
    first = np.array([begin + np.argmin(force[begin:end]) for begin, end in runs], dtype=np.int64)
    return IsolatedBranches(force[first], highest[first], first)


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
