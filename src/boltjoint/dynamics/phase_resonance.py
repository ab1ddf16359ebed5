"""Peaks of the first harmonic by multi-harmonic balance, followed by the phase of the output point.

A resonance is followed by the phase of the output point behind the excitation, with the frequency
as an unknown: the phase turns by half a circle through a resonance and the frequency is a function
of it even where the response folds over, so there are no turning points and no bends near the peak
(Peter and Leine 2017 measure nonlinear modes by such a phase).

References
----------
S. Peter, R. I. Leine: Excitation power quantities in phase resonance testing of nonlinear systems
with phase-locked-loop excitation. Mechanical Systems and Signal Processing 96 (2017) 139-158.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.output_point import OutputPoint
from boltjoint.dynamics.periodic_motion import PeriodicMotion
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint
from boltjoint.options import Options
from boltjoint.solvers.equations import Derivative, Equations, StepControl
from boltjoint.solvers.newton_krylov import NewtonKrylov

Array = NDArray[np.float64]

#: distances of phases [rad] from that of a peak whose slopes tell how sharp it is: nearer ones are
#: apart by the jumps of sampled friction
_NEAREST, _FARTHEST = 0.01, 0.3
#: sharpness of a peak whose dissipation grows with the fourth power of the amplitude, above that of
#: microslip: peaks are not flatter
_FLATTEST = 0.25


@dataclass(frozen=True)
class PeakSearch(Options):
    """Search of a peak with more harmonics, near that with fewer.

    Parameters
    ----------
    overshoot
        First step of the phase over the distance at which a linear resonance has its peak.
    smallest_step, largest_step
        Steps of the phase [rad] in which the peak is bracketed, doubled while it lies beyond.
    largest_turn
        Of the phase [rad] from that of the peak with fewer harmonics: there is no peak beyond.
    largest_distance
        From the frequency of the peak with fewer harmonics, over it: beyond it lies another
        resonance.
    width
        Within which the phase of the peak is located [rad]: the amplitude is off by half of its
        square, the frequency by it times the damping ratio, both less than truncation errors.
    tolerance
        Residual of the equations, over the force. The error of 256 samples is 1e-5 and more.
    iterations
        Corrections after which a solution is given up, and a smaller step tried.
    """

    overshoot: float = 1.5
    smallest_step: float = 1e-4
    largest_step: float = 0.2
    largest_turn: float = 1.4
    largest_distance: float = 0.1
    width: float = 3e-3
    tolerance: float = 1e-6
    iterations: int = 50


class LocatedPeak(NamedTuple):
    """A peak of the first harmonic.

    ``frequency`` [Hz] and ``motion``; ``frequency_by_phase``, the derivative of ln w by the phase;
    ``sharpness``, minus the second derivative of the logarithm of the amplitude by the phase: 1 at
    a linear resonance, less where friction makes the peak flat; ``distance`` by which its phase may
    be off [rad], and ``amplitude_error``, relative, from the slope of the amplitude that is left.
    """

    frequency: float
    motion: PeriodicMotion
    frequency_by_phase: float
    sharpness: float
    distance: float
    amplitude_error: float

    def frequency_error(self, amplitude_error: float) -> float:
        """Relative error of the frequency by that of the amplitude, e.

        Within e the peak may be anywhere in a phase of ``sqrt(2 e / sharpness)``.
        """
        phase = np.sqrt(2 * amplitude_error / self.sharpness) + self.distance
        return float(abs(self.frequency_by_phase) * phase)


class PhaseEquations(Equations):
    """Harmonic balance with the frequency as unknown and the phase of the output as parameter.

    The unknown is x and, after it, ``ln w`` times the size of x; the parameter is the phase theta
    of the first harmonic ``s + i c`` of the output point, for which ``Im((s + i c) e^(-i theta))``
    vanishes.

    Parameters
    ----------
    balance
        The modal equations, in linear modes.
    scale
        Size of x.
    amplitude
        Of the output point [m], to which its deviation from the phase is compared.
    """

    def __init__(self, balance: HarmonicBalance, scale: float, amplitude: float) -> None:
        self.balance, self.output = balance, OutputPoint(balance)
        self.residual_scale = float(np.linalg.norm(balance.modal_force))
        self._size = scale
        self._weight = self.residual_scale / amplitude
        shape = len(balance.components), -1
        mode = balance.joint.response_mode
        self._sin, self._cos = (np.zeros((shape[0], mode.size)) for _ in range(2))
        self._sin[balance.components.index("sin")] = mode
        self._cos[balance.components.index("cos")] = mode

    @classmethod
    def near(
        cls, balance: HarmonicBalance, motion: PeriodicMotion, frequency: float
    ) -> tuple["PhaseEquations", Array, float]:
        """The equations near a motion at a frequency [Hz], its unknown, and its phase [rad]."""
        x, output = motion.in_components(balance.components).ravel(), OutputPoint(balance)
        equations = cls(balance, float(np.linalg.norm(x)), output.value(x))
        return equations, equations.unknown(x, 2 * np.pi * frequency), float(np.angle(output(x)))

    def unknown(self, x: Array, w: float) -> Array:
        """The unknown of a motion at a frequency [rad/s]."""
        return np.append(x, self._size * np.log(w))

    def solution(self, y: Array) -> tuple[Array, float]:
        """Motion and frequency [rad/s] of an unknown."""
        return y[:-1], float(np.exp(self.log_frequency(y)))

    def log_frequency(self, y: Array) -> float:
        """Logarithm of the frequency of an unknown, or its change in that of an unknown."""
        return float(y[-1] / self._size)

    def evaluate(self, x: Array, p: float) -> tuple[Array, Derivative]:
        """Residual and Jacobian at the phase p [rad]."""
        q, w = self.solution(x)
        residual, by_motion = self.balance.residual_and_jacobian(q, w)
        by_frequency, across = self._borders(q, w, p)

        def jacobian() -> Array:
            return _bordered(by_motion(), by_frequency, across)

        def along(dy: Array) -> Array:
            dq, dw = dy[:-1], dy[-1]
            return np.append(by_motion.along(dq) + dw * by_frequency, across @ dq)

        return np.append(residual, across @ q), Derivative(jacobian, along)

    def bordered(self, by_motion: Array, x: Array, p: float) -> Array:
        """The Jacobian at the phase p from that of the balance."""
        return _bordered(by_motion, *self._borders(*self.solution(x), p))

    def parameter_derivative(self, x: Array, p: float) -> Array:
        """Derivative of the residual by the phase."""
        along = np.sin(p) * self._cos + np.cos(p) * self._sin
        return np.append(np.zeros(x.size - 1), -self._weight * along.ravel() @ x[:-1])

    def _borders(self, q: Array, w: float, p: float) -> tuple[Array, Array]:
        """Derivatives of the balance by the last unknown, and of the last equation by the motion.

        Both have the shape of q.
        """
        across = self._weight * (np.cos(p) * self._cos - np.sin(p) * self._sin)
        return w / self._size * self.balance.frequency_derivative(q, w), across.ravel()


def _bordered(by_motion: Array, by_frequency: Array, across: Array) -> Array:
    return np.block([[by_motion, by_frequency[:, None]], [across, np.zeros(1)]])


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
) -> LocatedPeak | None:
    """Peak of the first harmonic by multi-harmonic balance, near that with fewer harmonics.

    The derivative of the amplitude by the phase, from the Jacobian of the balance, vanishes there.
    The damping of the harmonic h is H(hw).

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
    LocatedPeak or None
        None without one within the largest distance.

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
    equations, y, phase = PhaseEquations.near(balance, start, frequency)
    resonance = _Resonance(equations, y, search)
    try:
        phase = _locate(resonance, phase, search)
    except _NotConverged:
        return None
    if phase is None:
        return None
    y, change = resonance.solutions[phase]
    q, w = equations.solution(y)
    at = w / (2 * np.pi)
    if abs(at - frequency) > search.largest_distance * frequency:
        return None
    motion = PeriodicMotion(law.components, q.reshape(len(law.components), -1))
    sharpness = resonance.sharpness(phase)
    slope = abs(resonance.slope(phase)) / resonance.square(phase)
    # at a corner the slope changes its sign within the width without being small
    distance = min(slope / sharpness, search.width)
    by_phase = equations.log_frequency(change)
    return LocatedPeak(at, motion, by_phase, sharpness, distance, slope * distance)


def _locate(resonance: "_Resonance", first: float, search: PeakSearch) -> float | None:
    """The phase of the peak near a first one; None without a peak."""
    low = high = first
    # half the square of an amplitude that is the cosine of the distance falls by distance * square
    step = search.overshoot * resonance.slope(first) / resonance.square(first)
    step = np.copysign(np.clip(abs(step), search.width, search.largest_step), step)
    while np.sign(resonance.slope(high)) == np.sign(step):
        if abs(high - first) > search.largest_turn or abs(step) < search.smallest_step:
            return None
        try:
            resonance.slope(high + step)
        except _NotConverged:
            step /= 2
        else:
            low, high = high, high + step
            step = np.clip(2 * step, -search.largest_step, search.largest_step)
    if abs(high - low) <= search.width:
        return min(low, high, key=lambda phase: abs(resonance.slope(phase)))
    peak = float(brentq(resonance.slope, low, high, xtol=search.width))
    resonance.slope(peak)
    return peak


class _Resonance:
    """Solutions of ``PhaseEquations`` by the phase, each started from the nearest one."""

    def __init__(self, equations: PhaseEquations, start: Array, search: PeakSearch) -> None:
        checks.instance("search", search, PeakSearch)
        self.solutions: dict[float, tuple[Array, Array]] = {}
        self._slopes: dict[float, float] = {}
        self._equations, self._start, self._search = equations, start, search
        control = StepControl(tolerance=search.tolerance, maximum_iterations=search.iterations)
        self._solver = NewtonKrylov(equations, control)

    def slope(self, phase: float) -> float:
        """Half the derivative of the squared amplitude by the phase."""
        if phase not in self._slopes:
            y, change = self._solution(phase)
            self.solutions[phase] = y, change
            self._slopes[phase] = self._equations.output.slope(y[:-1], change[:-1])
        return self._slopes[phase]

    def square(self, phase: float) -> float:
        """Squared amplitude where the slope is known."""
        return self._equations.output.value(self.solutions[phase][0][:-1]) ** 2

    def sharpness(self, phase: float) -> float:
        """Minus the second derivative of the logarithm of the amplitude, near a peak at a phase.

        The smallest by the slopes of solutions around; the smallest there is without any.
        """
        square = self.square(phase)
        secants = [
            (self.slope(phase) - slope) / (other - phase) / square
            for other, slope in self._slopes.items()
            if _NEAREST <= abs(other - phase) <= _FARTHEST
        ]
        return max(min(secants, default=_FLATTEST), _FLATTEST)

    def _solution(self, phase: float) -> tuple[Array, Array]:
        """The solution at a phase, and its derivative by the phase."""
        guesses = [self._start]
        if self.solutions:
            nearest = min(self.solutions, key=lambda other: abs(other - phase))
            y, change = self.solutions[nearest]
            guesses = [y + (phase - nearest) * change, y]
        for guess in guesses:
            found = self._solver.solve(guess, phase)
            change = self._solver.derivative(found.x, phase) if found.converged else None
            if change is not None:
                return found.x, change
        if not self.solutions or abs(phase - nearest) < self._search.smallest_step:
            raise _NotConverged
        # by a solution between
        self.slope((phase + nearest) / 2)
        return self._solution(phase)


class _NotConverged(Exception):
    """The corrector did not converge at a phase."""
