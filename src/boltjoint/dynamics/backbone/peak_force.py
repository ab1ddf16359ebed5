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

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.backbone.between_states import BetweenStates, solve_minimum
from boltjoint.dynamics.backbone.epmc import ModalState
from boltjoint.solvers.step_control import StepControl

#: a smaller relative fall of the excitation between states is within the tolerance of their modes
_ROUNDING = 1e-6


class IsolatedBranches(NamedTuple):
    """States between whose excitations there are isolated branches, as indices, shape (ranges,).

    ``appears`` has the lowest excitation of a branch, ``merges`` the highest one, before it.
    """

    appears: NDArray[np.int64]
    merges: NDArray[np.int64]


def find_isolated_branches(force: NDArray[np.float64]) -> IsolatedBranches:
    """States whose excitations reach several intervals of amplitudes of a backbone.

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
    appears = [begin + np.argmin(force[begin:end]) for begin, end in runs]
    merges = [np.argmax(force[:begin]) for begin, _ in runs]
    return IsolatedBranches(np.array(appears, dtype=np.int64), np.array(merges, dtype=np.int64))


def least_near(
    function: Callable[[ModalState], float],
    states: Sequence[ModalState],
    place: int,
    control: StepControl,
) -> ModalState:
    """The state at a place of a backbone, or one between it and a neighbour with a lower function.

    Parameters
    ----------
    function
        Function of a state, no higher at this state than at its neighbours.
    states, place
        States of the backbone, and the index of one.
    control
        Tolerance of the equations, and scale of the amplitude.
    """
    least = states[place]
    for first, second in pairwise(states[max(place - 1, 0) : place + 2]):
        solved = solve_minimum(function, BetweenStates(first, second, control))
        if solved is not None and function(solved) < function(least):
            least = solved
    return least


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
