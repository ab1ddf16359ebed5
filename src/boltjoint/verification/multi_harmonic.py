"""Which periodic motion is left when harmonics are no longer missing? Balance of very many.

Friction is sampled in time, and damping is one that a march in time knows as well: at the frequency
w of the excitation, the loss factor eta is the viscous damping ``C = eta L / w``. Both are the same
for the first harmonic; the harmonic h is damped h times as much.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import brentq

from boltjoint import checks
from boltjoint.dynamics.branch import OutputPoint
from boltjoint.dynamics.harmonic_balance import HarmonicBalance, parse_component
from boltjoint.dynamics.linear_modes import LinearModes
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import LazyJacobian, StepControl
from boltjoint.solvers.newton import newton, solve

logger = logging.getLogger(__name__)

#: longest and shortest step in which a peak is bracketed, over its frequency, and how far from
#: where it is with fewer harmonics it is sought
_STEP, _SHORTEST_STEP, _FARTHEST = 2e-3, 1e-5, 0.1

#: relative width within which the frequency of a peak is located
_WIDTH = 1e-6

#: ... and what may be left of the equations there, over the force: the samples err by more
_TOLERANCE = 1e-6


@dataclass(frozen=True)
class ViscousBalance(HarmonicBalance):
    """``HarmonicBalance`` of sampled friction with losses ``h eta L`` in the harmonic h.

    The contact is added up in modal coordinates, not point by point: hundreds of harmonics of a few
    modes stay affordable.
    """

    def residual(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """What is left of the equations at x and w, shape of x."""
        return self.residual_and_jacobian(x, w)[0]

    def residual_and_jacobian(
        self, x: NDArray[np.float64], w: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual, and what forms its exact derivative by x."""
        amplitude = x.reshape(len(self.components), -1)
        force, tangent = self.joint.law.modal_force_and_tangent(self.contact.rows, amplitude)
        linear = self.dynamic_stiffness(w)
        residual = linear @ x + force.ravel() - self.modal_force
        return residual, lambda: linear + tangent.reshape(x.size, x.size)

    def _loss_factor_of(self, harmonic: int) -> float:
        """Loss factor of a harmonic under viscous damping [-]."""
        return harmonic * self.loss_factor


@dataclass(frozen=True)
class PeriodicMotion:
    """A motion of the modes by its harmonics.

    Parameters
    ----------
    components
        As a law names them: ``sin``, ``cos``, ``sin2`` and so on, ``bias`` where there is one.
    modal_coordinate
        Amplitudes of the modes [kg^1/2 m], shape (components, modes).
    converged
        Whether the equations hold.

    Raises
    ------
    ValueError
        If there is not a row for each component.
    """

    components: tuple[str, ...]
    modal_coordinate: NDArray[np.float64]
    converged: bool = True

    def __post_init__(self) -> None:
        """Refuse amplitudes that do not fit the components; not converged, they may be anything."""
        shape = len(self.components), "modes"
        found = checks.array("modal_coordinate", self.modal_coordinate, shape, finite=False)
        object.__setattr__(self, "modal_coordinate", found)

    def in_components(self, components: tuple[str, ...]) -> NDArray[np.float64]:
        """Amplitudes of other components, zero where there are none, (components, modes)."""
        found = dict(zip(self.components, self.modal_coordinate, strict=True))
        nothing = np.zeros(self.modal_coordinate.shape[1])
        return np.array([found.get(name, nothing) for name in components])

    def in_time(self, samples: int) -> NDArray[np.float64]:
        """The modes at equally spaced times of a period [kg^1/2 m], shape (samples, modes)."""
        samples = checks.whole("samples", samples, at_least=1)
        phase = 2 * np.pi * np.arange(samples) / samples
        total = np.zeros((samples, self.modal_coordinate.shape[1]))
        for name, amplitude in zip(self.components, self.modal_coordinate, strict=True):
            part, harmonic = parse_component(name)
            shape = np.sin if part == "sin" else np.cos
            total += np.outer(shape(harmonic * phase), amplitude)
        return total

    def amplitude(self, mode: NDArray[np.float64]) -> complex:
        """First harmonic [m] of a point with these modes: sine coefficient + i cosine."""
        mode = checks.array("mode", mode, self.modal_coordinate.shape[1:])
        sin, cos = self.in_components(("sin", "cos")) @ mode
        return complex(sin, cos)


def solve_periodic(
    joint: Joint,
    frequency: float,
    force: float,
    loss_factor: float,
    *,
    harmonics: int,
    samples: int = 1024,
    start: PeriodicMotion | None = None,
    control: StepControl | None = None,
) -> PeriodicMotion:
    """Solve the balance of many harmonics at one frequency.

    Parameters
    ----------
    joint
        With its elements' own law, constant or variable.
    frequency, force
        Of the excitation [Hz], [N].
    loss_factor
        eta, as viscous damping [-].
    harmonics
        The highest harmonic.
    samples
        Samples a period.
    start
        A motion to start from, of any harmonics; by default that of the joint while all contact
        sticks. Few harmonics lead to more of them.
    control
        Tolerance and most iterations.

    Raises
    ------
    ValueError
        If the friction of the joint is sampled already, there are too few samples for the
        harmonics, the start is of another joint, or a number is out of range.
    """
    checks.instance("joint", joint, Joint)
    frequency = checks.number("frequency", frequency, above=0)
    force = checks.number("force", force, above=0)
    control = StepControl(maximum_iterations=50) if control is None else control
    checks.instance("control", control, StepControl)
    w = 2 * np.pi * frequency
    law = AlternatingFrequencyTime(joint.law, harmonics, samples)
    balance = ViscousBalance(replace(joint, law=law), loss_factor, force)
    if start is None:
        x = balance.stuck_solution(w)
    else:
        checks.instance("start", start, PeriodicMotion)
        shape = "components", joint.natural_frequency.size
        x = checks.array("start", start.in_components(law.components), shape).ravel()
    solution, _ = newton(LinearModes(balance), x, w, control)
    amplitude = solution.x.reshape(len(law.components), -1)
    return PeriodicMotion(law.components, amplitude, solution.converged)


def largest_response(response: xr.Dataset, force: float) -> tuple[float, PeriodicMotion] | None:
    """Frequency [Hz] and motion at the peak of the response to a force.

    Where it has none, at the largest solution that converged; None where none did.

    Parameters
    ----------
    response
        ``response.nc`` of any number of harmonics.
    force
        One of its force levels [N].

    Raises
    ------
    ValueError
        If it is no response.
    """
    checks.instance("response", response, xr.Dataset)
    solved = (response["excitation_force"] == force) & (response["converged"] == 1)
    mine = np.flatnonzero(solved)
    if not mine.size:
        return None
    amplitude = response["response_amplitude"].to_numpy()[mine]
    peak = response["peak_amplitude"].to_numpy()[response["force_level"] == force]
    at_peak = np.flatnonzero(amplitude == peak)
    at = response.isel(solution=mine[at_peak[0] if at_peak.size else amplitude.argmax()])
    components = tuple(str(name) for name in at["component"].to_numpy())
    amplitude = at["modal_coordinate"].transpose("component", "mode").to_numpy()
    return float(at["frequency"]), PeriodicMotion(components, amplitude)


def find_peak(
    joint: Joint,
    frequency: float,
    force: float,
    loss_factor: float,
    start: PeriodicMotion,
    *,
    harmonics: int,
    samples: int = 256,
    control: StepControl | None = None,
) -> tuple[float, PeriodicMotion] | None:
    """The peak of the first harmonic's amplitude with so many harmonics, near one with fewer.

    It lies where the derivative of the amplitude by the frequency vanishes, which the Jacobian of
    the balance gives. The loss factor is the same at every harmonic.

    Parameters
    ----------
    joint
        With its elements' own law, constant or variable.
    frequency, start
        Where a balance of fewer harmonics has its peak [Hz], and its motion there.
    force, loss_factor
        Of the excitation [N]; eta [-].
    harmonics
        The highest harmonic.
    samples
        Samples a period.
    control
        Tolerance and most iterations.

    Returns
    -------
    tuple of float and PeriodicMotion, or None
        Frequency [Hz] and motion of the peak; None where there is none within a tenth of the
        frequency that the balance leads to.

    Raises
    ------
    ValueError
        If an argument is none of this kind.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("start", start, PeriodicMotion)
    frequency = checks.number("frequency", frequency, above=0)
    law = AlternatingFrequencyTime(joint.law, harmonics, samples)
    balance = HarmonicBalance(replace(joint, law=law), loss_factor, force)
    equations, observe = LinearModes(balance), OutputPoint(balance)
    control = control or StepControl(tolerance=_TOLERANCE, maximum_iterations=50)
    found: dict[float, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
    begin = 2 * np.pi * frequency

    def slope(w: float) -> float:
        """Derivative of the squared amplitude by the frequency."""
        if found:
            nearest = min(found, key=lambda other: abs(other - w))
            x, change = found[nearest]
            guesses = [x + (w - nearest) * change, x]
        else:
            guesses = [start.in_components(law.components).ravel()]
        for guess in guesses:
            solution, jacobian = newton(equations, guess, w, control)
            change = solve(jacobian, -equations.parameter_derivative(solution.x, w))
            if solution.converged and change is not None:
                found[w] = solution.x, change
                return observe.slope(solution.x, change)
        raise _NotFound

    try:
        low = high = begin
        step = np.copysign(_STEP * begin, slope(begin))
        while np.sign(observe.slope(*found[high])) == np.sign(step):
            if abs(high - begin) > _FARTHEST * begin or abs(step) < _SHORTEST_STEP * begin:
                return None
            try:
                slope(high + step)
            except _NotFound:
                step /= 2
            else:
                low, high = high, high + step
        peak = brentq(slope, low, high, xtol=_WIDTH * begin)
        slope(float(peak))
    except _NotFound:
        return None
    amplitude = found[peak][0].reshape(len(law.components), -1)
    return peak / (2 * np.pi), PeriodicMotion(law.components, amplitude)


class _NotFound(Exception):
    """No solution was found at a frequency."""


def tabulate_peaks(
    joint: Joint,
    response: xr.Dataset,
    *,
    forces: Sequence[float],
    harmonics: Sequence[int] = (3, 5, 7, 9),
) -> pd.DataFrame:
    """Peaks by the number of harmonics balanced, each at its own frequency.

    Parameters
    ----------
    joint, response
        ``joint.nc`` and the ``response.nc`` of it, whose peaks the table begins with.
    forces
        Those of its force levels to take.
    harmonics
        Highest harmonics of the further balances, each of which starts from the one before.

    Returns
    -------
    DataFrame
        A row for each force and number of harmonics with columns ``force_N, harmonics,
        peak_frequency_Hz, peak_mm_per_N`` (NaN where no peak was found), and
        ``peak_frequency_error_percent, peak_amplitude_error_percent`` against the most harmonics
        with which it was, NaN where it was with one number only.

    Raises
    ------
    ValueError
        If a force is not among the levels of the response.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("response", response, xr.Dataset)
    forces = checks.numbers("forces", forces)
    if not np.isin(forces, response["force_level"]).all():
        raise ValueError(f"forces are {forces}: they must be among the levels of the response")
    loss_factor = response.attrs["loss_factor"]
    solved = max(parse_component(str(name))[1] for name in response["component"].to_numpy())
    harmonics = [number for number in harmonics if number > solved]
    if isinstance(joint.law, AlternatingFrequencyTime):
        joint = replace(joint, law=joint.law.elements)
    rows = []
    for force in forces:
        peaks = {}
        at_peak = response.sel(force=response["force_level"].to_numpy() == force)
        if np.isfinite(at_peak["peak_frequency"]).all():
            place = largest_response(response, force)
            peaks[solved] = place
            for highest in harmonics:
                found = find_peak(joint, place[0], force, loss_factor, place[1], harmonics=highest)
                logger.info("%g N, %d harmonics: %s", force, highest, found and found[0])
                if found is not None:
                    peaks[highest] = place = found
        for highest in (solved, *harmonics):
            frequency, motion = peaks.get(highest, (np.nan, None))
            amplitude = np.nan if motion is None else abs(motion.amplitude(joint.response_mode))
            rows.append(
                {
                    "force_N": float(force),
                    "harmonics": highest,
                    "peak_frequency_Hz": frequency,
                    "peak_mm_per_N": 1e3 * amplitude / force,
                }
            )
    columns = ["force_N", "harmonics", "peak_frequency_Hz", "peak_mm_per_N"]
    table = pd.DataFrame(rows, columns=columns)
    found = table.dropna().groupby("force_N")
    truth = found.last()[found.size() > 1]
    for what, column in (("frequency", columns[2]), ("amplitude", columns[3])):
        ratio = table[column] / table["force_N"].map(truth[column])
        table[f"peak_{what}_error_percent"] = 100 * (ratio - 1)
    return table
