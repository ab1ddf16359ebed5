"""Multi-harmonic balance with alternating frequency/time (AFT) as a reference for one harmonic.

For comparison with time integration, the damping H of the structure is the viscous damping
``C = H(w) / w`` at the excitation frequency w: the same for the first harmonic, ``h H(w)`` for the
harmonic h. Damping that is viscous already stays what it is.
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
from boltjoint.damping import Damping, damping_of_attributes
from boltjoint.dynamics.branch import OutputPoint
from boltjoint.dynamics.harmonic_balance import HarmonicBalance, parse_component
from boltjoint.dynamics.linear_modes import LinearModes
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint
from boltjoint.options import Options
from boltjoint.solvers.equations import LazyJacobian, StepControl
from boltjoint.solvers.newton import newton, solve

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class PeakSearch(Options):
    """Search of a peak with more harmonics, near that with fewer.

    Parameters
    ----------
    first_step, smallest_step, largest_step
        Steps in which the peak is bracketed, over its frequency: a quarter of the width of a
        resonance with a damping ratio of 1e-3, doubled while the peak lies beyond; a fiftieth of
        that; and its width.
    largest_distance
        From the peak with fewer harmonics, over its frequency: beyond it lies another resonance.
    width
        Within which the frequency is located, relative.
    tolerance
        Residual of the equations, over the force. The error of 256 samples is 1e-5 and more.
    iterations
        Corrections after which a solution is given up, and a smaller step tried.
    """

    first_step: float = 5e-4
    smallest_step: float = 1e-5
    largest_step: float = 2e-3
    largest_distance: float = 0.1
    width: float = 1e-6
    tolerance: float = 1e-6
    iterations: int = 25


@dataclass(frozen=True)
class ViscousBalance(HarmonicBalance):
    """``HarmonicBalance`` of sampled friction with viscous damping ``h H(w)`` of the harmonic h.

    AFT sums the contact forces in modal coordinates, not point by point: hundreds of harmonics of a
    few modes stay affordable.
    """

    def residual(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """Residual of the equations at x and w, shape of x."""
        return self.residual_and_jacobian(x, w)[0]

    def residual_and_jacobian(
        self, x: NDArray[np.float64], w: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and its lazily evaluated Jacobian."""
        amplitude = x.reshape(len(self.components), -1)
        force, tangent = self.joint.law.modal_force_and_tangent(self.contact.rows, amplitude)
        linear = self.dynamic_stiffness(w)
        residual = linear @ x + force.ravel() - self.modal_force
        return residual, lambda: linear + tangent.reshape(x.size, x.size)

    def _damping_of_harmonic(self, harmonic: int, w: float) -> tuple[int, float]:
        """``h H(w)``: the damping of the harmonic h under ``C = H(w) / w``."""
        return harmonic, w


@dataclass(frozen=True)
class PeriodicMotion:
    """A periodic motion of the modes by its harmonics.

    Parameters
    ----------
    components
        As a law names them: ``sin``, ``cos``, ``sin2`` and so on, ``bias`` where there is one.
    modal_coordinate
        Amplitudes of the modes [kg^1/2 m], shape (components, modes).
    converged
        Whether it solves the equations.

    Raises
    ------
    ValueError
        If there is not a row for each component.
    """

    components: tuple[str, ...]
    modal_coordinate: NDArray[np.float64]
    converged: bool = True

    def __post_init__(self) -> None:
        """Refuse amplitudes of another shape; without convergence they need not be finite."""
        shape = len(self.components), "modes"
        amplitude = checks.array("modal_coordinate", self.modal_coordinate, shape, finite=False)
        object.__setattr__(self, "modal_coordinate", amplitude)

    def in_components(self, components: tuple[str, ...]) -> NDArray[np.float64]:
        """Amplitudes of other components, zero where there are none, (components, modes)."""
        amplitudes = dict(zip(self.components, self.modal_coordinate, strict=True))
        zero = np.zeros(self.modal_coordinate.shape[1])
        return np.array([amplitudes.get(name, zero) for name in components])

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
        Of the excitation [Hz], [N].
    damping
        Of the structure, as viscous damping; a number is a loss factor.
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
    force = checks.number("force", force, above=0)
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
    solution, _ = newton(LinearModes(balance), x, w, control)
    amplitude = solution.x.reshape(len(law.components), -1)
    return PeriodicMotion(law.components, amplitude, solution.converged)


def motion_at_peak(response: xr.Dataset, force: float) -> tuple[float, PeriodicMotion] | None:
    """Frequency [Hz] and motion at the peak of the response to a force.

    Without a peak, at the largest converged solution; None without one.

    Parameters
    ----------
    response
        ``response.nc`` of any number of harmonics.
    force
        One of its force levels [N].

    Raises
    ------
    ValueError
        If the response is no dataset.
    """
    checks.instance("response", response, xr.Dataset)
    converged = (response["excitation_force"] == force) & (response["converged"] == 1)
    solutions = np.flatnonzero(converged)
    if not solutions.size:
        return None
    amplitude = response["response_amplitude"].to_numpy()[solutions]
    peak = response["peak_amplitude"].to_numpy()[response["force_level"] == force]
    at_peak = np.flatnonzero(amplitude == peak)
    at = response.isel(solution=solutions[at_peak[0] if at_peak.size else amplitude.argmax()])
    components = tuple(str(name) for name in at["component"].to_numpy())
    amplitude = at["modal_coordinate"].transpose("component", "mode").to_numpy()
    return float(at["frequency"]), PeriodicMotion(components, amplitude)


def find_peak(
    joint: Joint,
    frequency: float,
    force: float,
    damping: Damping | float,
    start: PeriodicMotion,
    *,
    harmonics: int,
    samples: int = 256,
    search: PeakSearch = PeakSearch(),
) -> tuple[float, PeriodicMotion] | None:
    """Peak of the first harmonic by multi-harmonic balance, near that with fewer harmonics.

    The derivative of the amplitude by the frequency, from the Jacobian of the balance, vanishes
    there. The damping of the harmonic h is H(hw).

    Parameters
    ----------
    joint
        With the law of its elements, constant or variable.
    frequency, start
        Peak frequency with fewer harmonics [Hz], and the motion there.
    force
        Amplitude of the excitation [N].
    damping
        Of the structure; a number is a loss factor.
    harmonics
        Number of harmonics.
    samples
        Time samples a period.
    search
        Steps and tolerances.

    Returns
    -------
    tuple of float and PeriodicMotion, or None
        Frequency [Hz] and motion of the peak; None without one within the largest distance.

    Raises
    ------
    ValueError
        If an argument is of another kind or out of range.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("start", start, PeriodicMotion)
    frequency = checks.number("frequency", frequency, above=0)
    law = AlternatingFrequencyTime(joint.law, harmonics, samples)
    balance = HarmonicBalance(replace(joint, law=law), damping, force)
    equations, output = LinearModes(balance), OutputPoint(balance)
    control = StepControl(tolerance=search.tolerance, maximum_iterations=search.iterations)
    solutions: dict[float, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
    begin = nearest = 2 * np.pi * frequency

    def slope(w: float) -> float:
        """Derivative of the squared amplitude by the frequency."""
        nonlocal nearest
        if solutions:
            nearest = min(solutions, key=lambda other: abs(other - w))
            x, change = solutions[nearest]
            guesses = [x + (w - nearest) * change, x]
        else:
            guesses = [start.in_components(law.components).ravel()]
        for guess in guesses:
            solution, _ = newton(equations, guess, w, control, chords=True)
            if not solution.converged:
                continue
            jacobian = equations.evaluate(solution.x, w)[1]()
            change = solve(jacobian, -equations.parameter_derivative(solution.x, w))
            if change is not None:
                solutions[w] = solution.x, change
                return output.slope(solution.x, change)
        if not solutions or abs(w - nearest) < search.smallest_step * begin:
            raise _NotConverged
        # by a solution between
        slope((w + nearest) / 2)
        return slope(w)

    try:
        low = high = begin
        largest = search.largest_step * begin
        step = np.copysign(search.first_step * begin, slope(begin))
        while np.sign(output.slope(*solutions[high])) == np.sign(step):
            if abs(high - begin) > search.largest_distance * begin:
                return None
            if abs(step) < search.smallest_step * begin:
                return None
            try:
                slope(high + step)
            except _NotConverged:
                step /= 2
            else:
                low, high = high, high + step
                step = np.clip(2 * step, -largest, largest)
        peak = brentq(slope, low, high, xtol=search.width * begin)
        slope(float(peak))
    except _NotConverged:
        return None
    amplitude = solutions[peak][0].reshape(len(law.components), -1)
    return peak / (2 * np.pi), PeriodicMotion(law.components, amplitude)


class _NotConverged(Exception):
    """The corrector did not converge at a frequency."""


def tabulate_peaks(
    joint: Joint,
    response: xr.Dataset,
    *,
    forces: Sequence[float],
    harmonics: Sequence[int] = (3, 5, 7, 9),
) -> pd.DataFrame:
    """Peaks by the number of harmonics, each at its own frequency.

    Parameters
    ----------
    joint, response
        A joint and its ``response.nc``, whose peaks the table begins with.
    forces
        Force levels of the response.
    harmonics
        Further numbers of harmonics, each started from the one before.

    Returns
    -------
    DataFrame
        A row for each force and number of harmonics with columns ``force_N, harmonics,
        peak_frequency_Hz, peak_mm_per_N`` (NaN without a peak), and ``peak_frequency_error_percent,
        peak_amplitude_error_percent`` against the most harmonics with a peak, NaN without others.

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
    damping = damping_of_attributes(response.attrs)
    of_response = max(parse_component(str(name))[1] for name in response["component"].to_numpy())
    harmonics = [number for number in harmonics if number > of_response]
    if isinstance(joint.law, AlternatingFrequencyTime):
        joint = replace(joint, law=joint.law.elements)
    joint, rows = joint.distinct, []
    for force in forces:
        peaks = {}
        at_peak = response.sel(force=response["force_level"].to_numpy() == force)
        if np.isfinite(at_peak["peak_frequency"]).all():
            peak = motion_at_peak(response, force)
            peaks[of_response] = peak
            for highest in harmonics:
                frequency, motion = peak
                found = find_peak(joint, frequency, force, damping, motion, harmonics=highest)
                logger.info("%g N, %d harmonics: %s", force, highest, found and found[0])
                if found is not None:
                    peaks[highest] = peak = found
        for highest in (of_response, *harmonics):
            frequency, motion = peaks.get(highest, (np.nan, None))
            amplitude = np.nan if motion is None else abs(motion.amplitude(joint.response_mode))
            rows.append((float(force), highest, frequency, 1e3 * amplitude / force))
    columns = ["force_N", "harmonics", "peak_frequency_Hz", "peak_mm_per_N"]
    table = pd.DataFrame(rows, columns=columns)
    by_force = table.dropna().groupby("force_N")
    reference = by_force.last()[by_force.size() > 1]
    for what, column in (("frequency", columns[2]), ("amplitude", columns[3])):
        ratio = table[column] / table["force_N"].map(reference[column])
        table[f"peak_{what}_error_percent"] = 100 * (ratio - 1)
    return table
