"""Periodic motions by their harmonics: energy, motion at a peak, superharmonic resonances.

The harmonic h of a motion vibrates at h times the excitation frequency w. For a small change of it
at that frequency the structure with its contact has the complex stiffness ``L + i H(hw) + K_h``,
K_h from the tangent of the contact at the motion itself. Where an eigenvalue lambda of that matrix
is so near to (hw)^2 that its damping, not its stiffness, limits the motion, the harmonic is in
resonance: ``|Re lambda - (hw)^2| <= Im lambda``, the half-power bandwidth. Motion with a damping
ratio above a quarter, such as that of points that slip, has no resonance.

References
----------
A. H. Nayfeh, D. T. Mook: Nonlinear Oscillations. Wiley, 1979: section 4.1.3.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.balance.harmonic_balance import (
    HarmonicBalance,
    stiffness_of_harmonic,
)
from boltjoint.harmonics import Components


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
        checks.sequence("components", self.components, str)
        object.__setattr__(self, "components", Components(self.components))
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
        components = Components(self.components)
        of_components = zip(
            components.number, components.is_sine, self.modal_coordinate, strict=True
        )
        for number, is_sine, amplitude in of_components:
            shape = np.sin if is_sine else np.cos
            total += np.outer(shape(number * phase), amplitude)
        return total

    def amplitude(self, mode: NDArray[np.float64]) -> complex:
        """First harmonic [m] of a point with these modes: sine coefficient + i cosine."""
        mode = checks.array("mode", mode, self.modal_coordinate.shape[1:])
        sin, cos = self.in_components(("sin", "cos")) @ mode
        return complex(sin, cos)


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


def energy_per_period(
    balance: HarmonicBalance, x: NDArray[np.float64], w: float
) -> tuple[float, float, float]:
    """Input energy, structural dissipation and friction dissipation in a period [J].

    The work of a force f on a displacement q is ``pi sum_h h (f_ch s_h - f_sh c_h)``. Input and
    dissipation balance where the equations hold in a space that holds q.

    Parameters
    ----------
    balance
        With the excitation.
    x, w
        An unknown of the balance, and the frequency [rad/s].
    """
    components = balance.components
    q = components.rows(x)

    def work(force: NDArray[np.float64]) -> float:
        f = components.rows(force)
        work_of = (h * (f[c] @ q[s] - f[s] @ q[c]) for h, s, c in components.harmonics)
        return float(np.pi * sum(work_of))

    force = balance.modal_force, balance.damping_force(x, w), balance.contact.force(x, w)
    return work(force[0]), work(force[1]), work(force[2])


def energy_error(balance: HarmonicBalance, x: NDArray[np.float64], w: float) -> float:
    """Input energy less dissipation, over the larger of both; 0 without motion."""
    supplied, structural, friction = energy_per_period(balance, x, w)
    larger = max(abs(supplied), abs(structural + friction))
    return (supplied - structural - friction) / max(larger, np.finfo(float).tiny)


class Superharmonic(NamedTuple):
    """A harmonic in resonance.

    ``order`` of the harmonic; ``frequency`` [Hz] of the mode, near order times that of the motion;
    ``share``: amplitude of the mode in that harmonic over that of all modes in the first, both in
    modal coordinates.
    """

    order: int
    frequency: float
    share: float


def find_superharmonic(
    balance: HarmonicBalance,
    jacobian: NDArray[np.float64],
    motion: PeriodicMotion,
    frequency: float,
    smallest_share: float = 1e-3,
    near: float = 0.01,
) -> Superharmonic | None:
    """The superharmonic resonance with the largest share in a motion; None without one.

    A harmonic is in resonance within the half-power bandwidth of a mode, or near its frequency:
    beside a mode of little damping it moves fifty times as much as without inertia, or more.

    Parameters
    ----------
    balance
        With the harmonics of the motion, in linear modes.
    jacobian
        Jacobian of the balance at the motion.
    motion, frequency
        A solution, and its frequency [Hz].
    smallest_share
        Smallest share of a resonance that counts: high harmonics pass many resonances with hardly
        any motion.
    near
        Relative distance from the frequency of a mode within which a harmonic is in resonance: a
        fifth harmonic at 0.13 % of it, beyond the bandwidth by a loss factor of 0.001, raised a
        peak by a third.
    """
    w = 2 * np.pi * frequency
    q = motion.in_components(balance.components)
    components = balance.components
    first = np.linalg.norm(q[[components.sin(), components.cos()]])
    resonances = []
    for h, s, c in components.harmonics:
        if h == 1:
            continue
        distance, vectors = np.linalg.eig(stiffness_of_harmonic(jacobian, components, h))
        amplitude = q[s] + 1j * q[c]
        share = abs(np.linalg.solve(vectors, amplitude)) / first
        squared = distance.real + (h * w) ** 2
        reach = np.maximum(distance.imag, 2 * near * squared)
        is_resonant = (abs(distance.real) <= reach) & (2 * distance.imag < squared)
        for mode in np.flatnonzero(is_resonant & (share >= smallest_share)):
            own = np.sqrt(squared[mode]) / (2 * np.pi)
            resonances.append(Superharmonic(h, float(own), float(share[mode])))
    return max(resonances, key=lambda resonance: resonance.share, default=None)
