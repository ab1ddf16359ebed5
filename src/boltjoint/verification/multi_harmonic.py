"""Multi-harmonic balance with alternating frequency/time (AFT) as a reference for one harmonic.

For comparison with time integration, the damping H of the structure is the viscous damping
``C = H(w) / w`` at the excitation frequency w: the same for the first harmonic, ``h H(w)`` for the
harmonic h. Damping that is viscous already stays what it is.
"""

import logging
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.harmonic_balance import HarmonicBalance, parse_component
from boltjoint.dynamics.linear_modes import LinearModes
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import StepControl
from boltjoint.solvers.newton import newton

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class ViscousBalance(HarmonicBalance):
    """``HarmonicBalance`` of sampled friction with viscous damping ``h H(w)`` of the harmonic h."""

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
