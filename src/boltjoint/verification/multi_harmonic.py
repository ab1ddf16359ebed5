"""Multi-harmonic balance with viscous damping, and tables of it against time integration.

For comparison with time integration, the damping H of the structure is the viscous damping
``C = H(w) / w`` at the excitation frequency w: the same for the first harmonic, ``h H(w)`` for the
harmonic h. Damping that is viscous already stays what it is.
"""

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint import checks
from boltjoint.damping import Damping, damping_of_attributes
from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance, Number
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion, motion_at_peak
from boltjoint.dynamics.response.harmonic_convergence import converge_peak
from boltjoint.friction.aft import AlternatingFrequencyTime, without_sampling
from boltjoint.joint.model import Joint
from boltjoint.solvers.newton import NewtonKrylov
from boltjoint.solvers.step_control import StepControl
from boltjoint.verification.time_integration import SteadyState, steady_state

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class ViscousBalance(HarmonicBalance):
    """``HarmonicBalance`` of sampled friction with viscous damping ``h H(w)`` of the harmonic h."""

    def _damping_of(self, harmonic: Number, w: float) -> tuple[Number, Number]:
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
    law = AlternatingFrequencyTime(joint.contact.element_law, harmonics, samples)
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


#: relative change of the amplitude below which more harmonics are not tried; a quarter of that to
#: which converged peaks are compared
_SMALL_CHANGE = 5e-4

#: of the tables of harmonics and time integration
_COLUMNS = (
    "force_N",
    "frequency_Hz",
    "harmonics",
    "amplitude_m",
    "in_time_m",
    "difference_percent",
    "from_rest_percent",
    "step_error_percent",
    "steps_per_period",
    "periods",
    "change_per_period",
    "settled",
)


def tabulate_time_integration(
    joint: Joint,
    response: xr.Dataset,
    *,
    forces: Sequence[float] | None = None,
    harmonics: Sequence[int] = (1, 3, 5, 9, 25, 51, 101, 201),
    samples: int = 1024,
    steps: int = 1000,
) -> pd.DataFrame:
    """First harmonic of the response by number of harmonics and by time integration.

    At the peak frequency of each force. The integration starts from the motion of the most
    harmonics, and once more at rest: the residual tractions of contacts without full slip, and the
    motion itself where there are several, depend on the start.

    Parameters
    ----------
    joint, response
        ``joint.nc`` and the ``response.nc`` of it, of any number of harmonics.
    forces
        Force levels of the response; by default all.
    harmonics
        Numbers of harmonics, each started from the one before. The last should reach beyond the
        stuck modes of the joint.
    samples
        Time samples a period of the multi-harmonic balances.
    steps
        Steps a period of the coarser time integration.

    Returns
    -------
    DataFrame
        A row for each force and number of harmonics with columns ``force_N, frequency_Hz,
        harmonics, amplitude_m`` (NaN where the balance did not converge); ``in_time_m``, the
        amplitude by time integration; the differences from it, ``difference_percent`` of the
        balance and ``from_rest_percent`` of the integration from rest; ``step_error_percent``,
        ``steps_per_period``, ``periods`` and ``change_per_period`` of the integration;
        ``settled``, whether both integrations converged.

    Raises
    ------
    ValueError
        If a force is not among the levels of the response, or as for ``steady_state``.
    """
    joint, forces, damping = checked_levels(joint, response, forces)
    harmonics = checks.indices("harmonics", harmonics, ("numbers",)).tolist()
    for number in harmonics:
        checks.whole("harmonics", number, at_least=1)
    samples = checks.whole("samples", samples, at_least=2 * max(harmonics) + 1)
    steps = checks.whole("steps", steps, at_least=3)
    rows: list[tuple[object, ...]] = []
    for force in forces:
        if (peak := motion_at_peak(response, force)) is not None:
            excitation = float(peak[0]), float(force), damping
            integrate = partial(steady_state, joint, *excitation, steps=steps)
            amplitudes, motion = _balanced(joint, excitation, peak[1], harmonics, samples)
            integrated = integrate(start=motion.in_time(steps))
            rows += _compared(excitation, amplitudes, integrated, from_rest=integrate())
    return pd.DataFrame(rows, columns=_COLUMNS)


def tabulate_steady_states(
    joint: Joint,
    response: xr.Dataset,
    *,
    forces: Sequence[float],
    harmonics: Sequence[int] = (17, 33, 65, 97),
    samples: int = 2048,
    steps: int = 1000,
    tolerance: float = 1e-6,
    maximum_periods: int = 600,
) -> pd.DataFrame:
    """Converged peaks against the steady state of time integration.

    At the frequency of the converged peak of each force, the integration starts from the motion of
    the most harmonics.

    Parameters
    ----------
    joint, response
        As for ``tabulate_time_integration``.
    forces
        Force levels of the response.
    harmonics
        Numbers of harmonics beyond those of the peak, until two successive changes of the amplitude
        are below half a thousandth: one may be chance.
    samples, steps
        As for ``tabulate_time_integration``.
    tolerance, maximum_periods
        As for ``steady_state``.

    Returns
    -------
    DataFrame
        As from ``tabulate_time_integration``, without the integration from rest; the first row of a
        force has the harmonics of its converged peak.

    Raises
    ------
    ValueError
        As for ``tabulate_time_integration``.
    """
    joint, forces, damping = checked_levels(joint, response, forces)
    harmonics = checks.indices("harmonics", harmonics, ("numbers",)).tolist()
    rows: list[tuple[object, ...]] = []
    for force in forces:
        if (peak := motion_at_peak(response, force)) is None:
            continue
        last = converge_peak(joint, *peak, force, damping).peaks[-1]
        numbers = [last.harmonics, *(number for number in harmonics if number > last.harmonics)]
        excitation = last.frequency, float(force), damping
        integrate = partial(
            steady_state,
            joint,
            *excitation,
            steps=steps,
            tolerance=tolerance,
            maximum_periods=maximum_periods,
        )
        amplitudes, motion = _balanced(
            joint, excitation, last.motion, numbers, samples, change=_SMALL_CHANGE
        )
        rows += _compared(excitation, amplitudes, integrate(start=motion.in_time(steps)))
    return pd.DataFrame(rows, columns=_COLUMNS)


def checked_levels(
    joint: Joint, response: xr.Dataset, forces: Sequence[float] | None
) -> tuple[Joint, Sequence[float], Damping]:
    """The joint with the law of its distinct elements, force levels, and damping."""
    checks.instance("joint", joint, Joint)
    checks.instance("response", response, xr.Dataset)
    levels = response["force_level"].to_numpy()
    some = levels.tolist() if forces is None else checks.levels("forces", forces)
    if not np.isin(some, levels).all():
        raise ValueError(f"forces are {some}: they must be among the levels of the response")
    joint = replace(joint, law=without_sampling(joint.law))
    return joint.distinct, some, damping_of_attributes(response.attrs)


def _balanced(
    joint: Joint,
    excitation: tuple[float, float, Damping],
    motion: PeriodicMotion,
    harmonics: Sequence[int],
    samples: int,
    *,
    change: float = 0.0,
) -> tuple[dict[int, float], PeriodicMotion]:
    """Amplitudes by number of harmonics, each started from the motion before, and the last motion.

    No further harmonics are tried once two successive changes of the amplitude are below a share.
    """
    amplitudes: dict[int, float] = {}
    for highest in harmonics:
        solution = solve_periodic(
            joint, *excitation, harmonics=highest, samples=samples, start=motion
        )
        amplitude = abs(solution.amplitude(joint.response_mode))
        amplitudes[highest] = amplitude if solution.converged else np.nan
        motion = solution if solution.converged else motion
        last = np.array(list(amplitudes.values())[-3:])
        if last.size == 3 and np.all(abs(last[1:] / last[:-1] - 1) < change):
            break
    return amplitudes, motion


def _compared(
    excitation: tuple[float, float, Damping],
    amplitudes: Mapping[int, float],
    integrated: SteadyState,
    from_rest: SteadyState | None = None,
) -> Iterator[tuple]:
    """Rows of a force: balances of more and more harmonics against the time integration."""
    in_time, settled = abs(integrated.amplitude), integrated.converged
    from_rest_percent = np.nan
    if from_rest is not None:
        from_rest_percent = 100 * (abs(from_rest.amplitude) / in_time - 1)
        settled = settled and from_rest.converged
    accuracy = 100 * integrated.step_error, integrated.steps, integrated.periods
    for highest, amplitude in amplitudes.items():
        place = excitation[1], excitation[0], highest
        difference_percent = 100 * (amplitude / in_time - 1)
        compared = amplitude, in_time, difference_percent, from_rest_percent
        yield (*place, *compared, *accuracy, integrated.change, settled)
