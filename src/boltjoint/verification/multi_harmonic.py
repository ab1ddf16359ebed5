"""Multi-harmonic balance with alternating frequency/time (AFT) as a reference for one harmonic.

For comparison with time integration, the damping H of the structure is the viscous damping
``C = H(w) / w`` at the excitation frequency w: the same for the first harmonic, ``h H(w)`` for the
harmonic h. Damping that is viscous already stays what it is.
"""

import logging
from dataclasses import dataclass, replace

import numpy as np

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import StepControl
from boltjoint.solvers.newton import NewtonKrylov

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class ViscousBalance(HarmonicBalance):
    """``HarmonicBalance`` of sampled friction with viscous damping ``h H(w)`` of the harmonic h."""

    def _damping_of(self, harmonic: int, w: float) -> tuple[int, float]:
        """``h H(w)``: the damping of the harmonic h under ``C = H(w) / w``."""
        return harmonic, w


def solve_periodic(
    joint: Joint,
    frequency: float,
    force: float,
    damping: Damping | float,
    *,
    harmonics: int,
    samples: int = 1024,
    start: PeriodicMotion | None = None,
    control: StepControl | None = None,
) -> PeriodicMotion:
    """Solve the multi-harmonic balance with viscous damping at one frequency.

    Parameters
    ----------
    joint
        With the law of its elements, constant or variable.
    frequency, force
        Frequency and force of the excitation [Hz], [N].
    damping
        Damping of the structure, as viscous damping; a number is a loss factor.
    harmonics
        Number of harmonics.
    samples
        Time samples a period.
    start
        Initial guess with any harmonics, such as the solution with fewer; by default the stuck
        solution.
    control
        Tolerance and maximum iterations.

    Raises
    ------
    ValueError
        If the friction of the joint is sampled already, there are too few samples for the
        harmonics, the start is of another joint, or a number is out of range.
    """
    checks.instance("joint", joint, Joint)
    frequency = checks.number("frequency", frequency, above=0)
    force = checks.level("force", force)
    control = StepControl(maximum_iterations=50) if control is None else control
    checks.instance("control", control, StepControl)
    w = 2 * np.pi * frequency
    law = AlternatingFrequencyTime(joint.law, harmonics, samples)
    balance = ViscousBalance(replace(joint, law=law), damping, force)
    if start is None:
        x = balance.stuck_solution(w)
    else:
        checks.instance("start", start, PeriodicMotion)
        shape = "components", joint.natural_frequency.size
        x = checks.array("start", start.in_components(law.components), shape).ravel()
    solution = NewtonKrylov(BalanceEquations(balance), control).solve(x, w)
    amplitude = law.components.rows(solution.x)
    return PeriodicMotion(law.components, amplitude, solution.converged)
