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

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator

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

#: sharpness that counts, at least: amplitudes of flatter peaks tell nothing of their phase
_FLATTEST = 0.02


@dataclass(frozen=True)
class PeakSearch(Options):
    """Search of a peak with more harmonics, near that with fewer.

    Parameters
    ----------
    spread
        Distance of the three phases [rad] whose amplitudes give a first parabola: wide, as sampled
        friction makes amplitudes rough. Their slopes are of no use: they jump where a sample
        changes its state, so that peaks found by a slope were up to 1.4 % too low.
    narrowing
        Ratio of spreads of parabolas that follow.
    smallest_step
        Step of the phase [rad] below which a solution that is not found is given up.
    largest_turn
        Of the phase [rad] from that of the peak with fewer harmonics: there is no peak beyond.
    largest_distance
        From the frequency of the peak with fewer harmonics, over it: beyond it lies another
        resonance.
    width
        Within which the phase of the peak is located [rad], by the vertices of two parabolas, where
        roughness allows: the amplitude is off by half of its square, the frequency by it times the
        damping ratio, both less than truncation errors.
    tolerance
        Residual of the equations, over the force. The error of 256 samples is 1e-5 and more.
    iterations
        Corrections after which a solution is given up, and a smaller step tried.
    """

    spread: float = 0.1
    narrowing: float = 3.0
    smallest_step: float = 1e-3
    largest_turn: float = 1.4
    largest_distance: float = 0.1
    width: float = 3e-3
    tolerance: float = 1e-6
    iterations: int = 50


class LocatedPeak(NamedTuple):
    """A peak of the first harmonic.

    ``frequency`` [Hz] and ``motion``; ``frequency_by_phase``, the largest change of ln w by the
    phase; ``sharpness``, minus the second derivative of the logarithm of the amplitude by the
    phase: 1 at a linear resonance, less where friction makes the peak flat; ``distance`` by which
    its phase may be off [rad], and ``amplitude_error``, relative: by that, and by roughness.
    """

    frequency: float
    motion: PeriodicMotion
    frequency_by_phase: float
    sharpness: float
    distance: float
    amplitude_error: float

    def frequency_error(self, amplitude_error: float) -> float:
        """Relative error of the frequency by that of the amplitude, e.

        Within e the peak is in a phase of ``sqrt(2 e / sharpness)``. Errors e of amplitudes that
        vary over a distance d move it by ``e / (d sharpness)``.
        """
        moved = amplitude_error / (PeakSearch().spread * self.sharpness)
        phase = min(np.sqrt(2 * amplitude_error / self.sharpness), moved) + self.distance
        return float(self.frequency_by_phase * phase)


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

    It is the vertex of a parabola through the logarithms of three amplitudes by the phase.
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
        peak = _locate(resonance, phase, search)
    except _NotConverged:
        return None
    if peak is None:
        return None
    q, w = equations.solution(resonance.solution(peak.vertex))
    at = w / (2 * np.pi)
    if abs(at - frequency) > search.largest_distance * frequency:
        return None
    motion = PeriodicMotion(law.components, q.reshape(len(law.components), -1))
    sharpness = max(peak.sharpness, _FLATTEST)
    # two standard deviations of the vertex, by those of three amplitudes
    moved = np.sqrt(2) * resonance.roughness(peak.vertex) / (peak.spread * sharpness)
    distance = peak.distance + min(moved, peak.spread)
    off = abs(resonance.log_amplitude(peak.vertex) - peak.highest)
    error = 2 * off + sharpness * distance**2 / 2
    return LocatedPeak(at, motion, peak.frequency_by_phase, sharpness, distance, error)


class _Parabola(NamedTuple):
    """Of the logarithm of the amplitude through three phases ``spread`` apart, the middle highest.

    ``vertex``, ``highest`` there; ``distance`` by which the vertex may be off.
    """

    spread: float
    vertex: float
    highest: float
    sharpness: float
    frequency_by_phase: float
    distance: float


def _locate(resonance: "_Resonance", first: float, search: PeakSearch) -> _Parabola | None:
    """The parabola of a peak near a first phase; None without a peak."""
    spread, best = search.spread, resonance.around_peak(first, search.spread)
    if best is None:
        return None
    while min(best.distance, spread) > search.width:
        spread /= search.narrowing
        parabola = resonance.around_peak(best.vertex, spread)
        if parabola is None:
            break
        # vertices converge with the spread at least, where amplitudes are not too rough for it
        distance = abs(parabola.vertex - best.vertex) / (search.narrowing - 1)
        low, high = (resonance.log_amplitude(one.vertex) for one in (best, parabola))
        if distance > best.distance and high < low:
            break
        sharpness = min(parabola.sharpness, best.sharpness)
        # of the widest, where frequencies are the least rough
        by_phase = best.frequency_by_phase
        best = parabola._replace(
            distance=distance, sharpness=sharpness, frequency_by_phase=by_phase
        )
    return best


class _Resonance:
    """Solutions of ``PhaseEquations`` by the phase, each started from those near it."""

    def __init__(self, equations: PhaseEquations, start: Array, search: PeakSearch) -> None:
        checks.instance("search", search, PeakSearch)
        self._solutions: dict[float, Array] = {}
        self._equations, self._start, self._search = equations, start, search
        control = StepControl(tolerance=search.tolerance, maximum_iterations=search.iterations)
        self._solver = NewtonKrylov(equations, control)

    def around_peak(self, first: float, spread: float) -> _Parabola | None:
        """The parabola uphill from a phase whose middle is the highest of its phases, or None."""
        moved = 0
        # the start is nearest to it
        self.solution(first)
        while abs(moved) * spread <= self._search.largest_turn:
            phases = first + spread * np.arange(moved - 1, moved + 2)
            below, at, above = (self.log_amplitude(phase) for phase in phases)
            if at >= max(below, above):
                return self._parabola(phases, np.array([below, at, above]))
            moved += 1 if above > below else -1
        return None

    def _parabola(self, phases: Array, values: Array) -> _Parabola:
        spread = phases[1] - phases[0]
        by_value = np.polyfit([-1.0, 0.0, 1.0], values, 2)
        w = [self._equations.log_frequency(self._solutions[phase]) for phase in phases]
        vertex = -by_value[1] / (2 * by_value[0]) if by_value[0] < 0 else 0.0
        return _Parabola(
            spread=spread,
            vertex=phases[1] + spread * vertex,
            highest=np.polyval(by_value, vertex),
            sharpness=-2 * by_value[0] / spread**2,
            frequency_by_phase=max(abs(np.diff(w))) / spread,
            distance=spread,
        )

    def roughness(self, phase: float) -> float:
        """Deviation of the logarithms of amplitudes near a phase from a cubic polynomial."""
        near = [x for x in self._solutions if abs(x - phase) <= 1.5 * self._search.spread]
        at = (np.array(near) - phase) / self._search.spread
        values = np.array([self.log_amplitude(x) for x in near])
        left = values - np.polyval(np.polyfit(at, values, 3), at)
        return float(np.linalg.norm(left) / np.sqrt(max(len(near) - 4, 1)))

    def log_amplitude(self, phase: float) -> float:
        """Logarithm of the amplitude of the output point."""
        q, _ = self._equations.solution(self.solution(phase))
        return float(np.log(self._equations.output.value(q)))

    def solution(self, phase: float) -> Array:
        """The solution at a phase."""
        if phase not in self._solutions:
            self._solutions[phase] = self._solve(phase)
        return self._solutions[phase]

    def _solve(self, phase: float) -> Array:
        known = sorted(self._solutions, key=lambda other: abs(other - phase))
        for guess in self._guesses(phase, known):
            found = self._solver.solve(guess, phase)
            moved = abs(self._equations.log_frequency(found.x - self._start))
            # other resonances have the same phases
            if found.converged and moved <= self._search.largest_distance:
                return found.x
        if not known or abs(phase - known[0]) < self._search.smallest_step:
            raise _NotConverged
        # by a solution between
        self.solution((phase + known[0]) / 2)
        return self._solve(phase)

    def _guesses(self, phase: float, known: list[float]) -> Iterator[Array]:
        """Interpolated between the three nearest known solutions, the nearest, or the start."""
        if len(known) > 1:
            near = known[:3]
            weights = BarycentricInterpolator(near, np.eye(len(near)))(phase)
            yield sum(x * self._solutions[one] for one, x in zip(near, weights, strict=True))
        yield self._solutions[known[0]] if known else self._start


class _NotConverged(Exception):
    """The corrector did not converge at a phase."""
