"""Periodic motions and their Floquet multipliers by shooting: Newton's method on a period in time.

Steps are those of ``time_integration``, so that no code is shared with friction laws, harmonic
balance or Hill's method. A motion is found whether it is stable or not, with all its harmonics.

References
----------
R. Seydel: Practical Bifurcation and Stability Analysis. Springer, third edition, 2010: chapter 7.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, as_damping
from boltjoint.friction.element_law import ElementLaw
from boltjoint.joint.model import Joint
from boltjoint.verification.time_integration import Integration

Array = NDArray[np.float64]

#: change of a state by which the period is differentiated, over the size of the motion: far above
#: rounding, and changes of contact state move by as little
_DIFFERENCE = 1e-6
#: derivatives by such differences are off by less
_ROUNDING = 1e-7


@dataclass(frozen=True)
class PeriodicOrbit:
    """A periodic motion, stable or not.

    Parameters
    ----------
    multipliers
        Floquet multipliers, largest first. Sliders that rest for the whole period and rigid-body
        motion are left out: they stay wherever they are, and nothing depends on it.
    motion
        Modal coordinates at the samples of the period [kg^1/2 m], shape (steps, modes).
    change
        Change of displacement and velocity of the modes over a period, relative to their size.
    converged
        Whether that is below the tolerance.
    """

    multipliers: NDArray[np.complex128]
    motion: Array
    change: float
    converged: bool


def find_orbit(
    joint: Joint,
    frequency: float,
    force: float,
    damping: Damping | float,
    start: Array,
    *,
    steps: int = 2000,
    tolerance: float = 1e-10,
    maximum_iterations: int = 12,
) -> PeriodicOrbit:
    """Periodic motion near a given one, and its multipliers by differences of the period.

    Every iteration integrates a period for each state of modes and sliders: for joints with few
    elements.

    Parameters
    ----------
    joint, frequency, force, damping
        As for ``time_integration.steady_state``.
    start
        Period of motion to begin with, modal coordinates at equally spaced times [kg^1/2 m], shape
        (samples, modes); the sliders follow it for two periods.
    steps
        Steps of a period.
    tolerance
        Change over a period, relative to the motion, below which it is periodic.
    maximum_iterations
        Maximum iterations of Newton's method.

    Raises
    ------
    ValueError
        If the friction of the joint is sampled, the start does not fit it, or a number is out of
        range.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("law of the joint", joint.law, ElementLaw)
    frequency = checks.number("frequency", frequency, above=0)
    force = checks.level("force", force)
    steps = checks.whole("steps", steps, at_least=3)
    tolerance = checks.number("tolerance", tolerance, above=0)
    maximum_iterations = checks.whole("maximum_iterations", maximum_iterations, at_least=1)
    start = checks.array("start", start, ("samples", joint.natural_frequency.size))
    checks.whole("length of start", len(start), at_least=1)
    period = _Period(Integration.of(joint, frequency, force, as_damping(damping), steps), start)
    state = period.begin
    for _ in range(maximum_iterations):
        after = period(state)
        motion = period.integration.motion()
        of_motion = slice(2 * period.integration.q.size)
        step = after - state
        change = np.linalg.norm(step[of_motion]) / np.linalg.norm(state[of_motion])
        derivative = period.derivative(state, after)
        moving = abs(derivative - np.eye(state.size)).max(axis=1) > _ROUNDING
        among = np.ix_(moving, moving)
        if change <= tolerance:
            break
        state = state.copy()
        state[moving] += np.linalg.solve(np.eye(moving.sum()) - derivative[among], step[moving])
    multipliers = np.linalg.eigvals(derivative[among])
    order = np.argsort(-abs(multipliers), kind="stable")
    return PeriodicOrbit(multipliers[order], motion, float(change), bool(change <= tolerance))


class _Period:
    """The state of modes and sliders after a period, as a function of that before.

    Parameters
    ----------
    integration
        Integration of the joint, in time.
    start
        Period of motion to begin with; one more is integrated, so that the changes in the last step
        are those of the steps.
    """

    def __init__(self, integration: Integration, start: Array) -> None:
        self.integration = integration
        integration.follow(start)
        integration.advance()
        self.begin = integration.state()
        sliders = integration.z.size
        forces = integration.elements[0] @ integration.history.T
        size = [np.full(self.begin.size - sliders, abs(start).max()), abs(forces).max(axis=1)]
        self._difference = _DIFFERENCE * np.concatenate(size)

    def __call__(self, state: Array) -> Array:
        """State after a period."""
        self.integration.restore(state)
        self.integration.advance()
        return self.integration.state()

    def derivative(self, state: Array, after: Array) -> Array:
        """Derivative of the state after by that before, by forward differences."""
        columns = []
        for i, difference in enumerate(self._difference):
            changed = state.copy()
            changed[i] += difference
            column = (self(changed) - after) / difference
            columns.append(column)
        return np.array(columns).T
