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
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.balance.balance_equations import PhaseEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response.amplitude_by_phase import (
    LocatedPeak,
    Parabola,
    deviation_from_polynomial,
    rise_within,
)
from boltjoint.dynamics.response.solutions_by_phase import SolutionsByPhase
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint
from boltjoint.options import Options
from boltjoint.solvers.newton import NewtonKrylov
from boltjoint.solvers.step_control import StepControl

Array = NDArray[np.float64]

#: sharpness that counts, at least: amplitudes of flatter peaks tell nothing of their phase
_FLATTEST = 0.01
#: standard deviations of three values within which their mean is, with a confidence of 95 %
_STUDENT = 4.3
#: distance from the phase of a peak at which motions are found from far [rad]
_BESIDE = 0.4


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
        Ratio of spreads of parabolas that follow. With more harmonics the last one is enough.
    smallest_step
        Step of the phase [rad] below which a solution that is not found is given up.
    largest_turn
        Largest turn of the phase [rad] from that of the peak with fewer harmonics: there is no peak
        beyond.
    largest_distance
        From the frequency of the peak with fewer harmonics, over it: beyond it lies another
        resonance.
    width
        Within which the phase of the peak is located [rad], by the vertices of two parabolas where
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

    @property
    def control(self) -> StepControl:
        """Tolerance and iterations of a solution."""
        return StepControl(tolerance=self.tolerance, maximum_iterations=self.iterations)


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

    It is the vertex of a parabola through the logarithms of three amplitudes by the phase. The
    damping of the harmonic h is H(hw).

    Parameters
    ----------
    joint
        With the law of its elements, constant or variable.
    frequency, start
        Peak frequency with fewer harmonics [Hz], and the motion there.
    force
        Amplitude of the excitation [N].
    damping
        Damping of the structure; a number is a loss factor.
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
    law = AlternatingFrequencyTime(joint.contact.element_law, harmonics, samples)
    balance = HarmonicBalance(replace(joint, law=law), damping, force)
    resonance = PhaseResonance(balance, frequency, start, search=search)
    located = resonance.peak()
    return None if located is None else resonance.with_sampling_error(located)


class PhaseResonance:
    """Motions near a resonance by the phase of the output point, each started from those near it.

    Parameters
    ----------
    balance
        In linear modes, with AFT.
    frequency, start
        Peak frequency with fewer harmonics [Hz], and the motion there, whose phase is
        ``first_phase`` [rad].
    fewer
        Motions with fewer harmonics, whose changes with the phase are those to expect.
    search
        Steps and tolerances.

    Raises
    ------
    ValueError
        If an argument is of another kind or out of range.
    """

    def __init__(
        self,
        balance: HarmonicBalance,
        frequency: float,
        start: PeriodicMotion,
        *,
        fewer: "PhaseResonance | None" = None,
        search: PeakSearch = PeakSearch(),
    ) -> None:
        checks.instance("start", start, PeriodicMotion)
        checks.instance("search", search, PeakSearch)
        frequency = checks.number("frequency", frequency, above=0)
        self.balance = balance
        self._equations, self._start, phase = PhaseEquations.near(balance, start, frequency)
        turns = 0 if fewer is None else round((fewer.first_phase - phase) / (2 * np.pi))
        self.first_phase: float = phase + 2 * np.pi * turns
        self._fewer, self._search = fewer, search
        self._solutions = SolutionsByPhase()
        self._solver = NewtonKrylov(self._equations, search.control)

    def peak(self, *, solved: bool = True) -> LocatedPeak | None:
        """The peak, its motion interpolated where not solved; None without one in reach."""
        if (parabola := self._parabola) is None:
            return None
        try:
            motion_at = self._solution if solved else self._solutions.between
            y = motion_at(parabola.vertex)
        except _NotConverged:
            return None
        motion, frequency = self._equations.motion(y, parabola.vertex)
        sharpness = max(parabola.sharpness, _FLATTEST)
        # vertices of rough amplitudes do not converge with the spread
        distance = parabola.distance + self._distance(parabola)
        off = abs(self._log_amplitude_of(y) - parabola.highest)
        phases = np.array(sorted(self._solutions))
        values = np.array([self._log_amplitude(one) for one in phases])
        rise = rise_within(distance, parabola.vertex, phases, values)
        return LocatedPeak(
            frequency=frequency,
            motion=motion,
            phase=parabola.vertex,
            frequency_by_phase=parabola.frequency_by_phase,
            sharpness=sharpness,
            distance=distance,
            amplitude_error=2 * off + max(rise, sharpness * distance**2 / 2),
        )

    def with_sampling_error(self, located: LocatedPeak) -> LocatedPeak:
        """A solved peak with its errors by where samples begin, with a confidence of 95 %.

        By three motions whose samples lie a third of their step apart, or other parts (Student's t
        of three). Not known where there are no three, nor of a peak that is not solved.
        """
        law = checks.instance("law", self.balance.joint.law, AlternatingFrequencyTime)
        if (phase := located.phase) not in self._solutions:
            return located
        y = self._solutions[phase]
        values = [(self._equations.log_frequency(y), self._log_amplitude_of(y))]
        for sixths in (2, 4, 3, 1, 5):
            equations, start = self._equations.beginning_at(y, sixths * np.pi / 3 / law.samples)
            solver = NewtonKrylov(equations, self._search.control, self._solver)
            if (x := self._find(solver, start, phase, y)) is not None:
                values.append((self._equations.log_frequency(x), self._log_amplitude_of(x)))
            if len(values) == 3:
                frequency, amplitude = _STUDENT * np.std(values, axis=0, ddof=1)
                return located._replace(sampling_error=(float(frequency), float(amplitude)))
        return located

    def start(self) -> tuple[PeriodicMotion, float] | None:
        """The motion at ``first_phase``, and its frequency [Hz]; None without one."""
        try:
            return self._equations.motion(self._solution(self.first_phase), self.first_phase)
        except _NotConverged:
            return None

    def slope_of_change(self, fewer: "PhaseResonance", phase: float) -> float:
        """Derivative of the change of ln amplitude from fewer harmonics by the phase [1/rad].

        From the phase of the peak to one beside it; not a number where a motion is not found.
        """
        beside = fewer._beside(phase)
        try:
            there = self._log_amplitude(beside) - fewer._log_amplitude(beside)
            here = self._log_amplitude(self.first_phase) - fewer._log_amplitude(phase)
        except _NotConverged:
            return np.nan
        return (there - here) / (beside - phase)

    @cached_property
    def _parabola(self) -> Parabola | None:
        """The parabola of the peak, as narrow as that with fewer harmonics had to be, or None."""
        try:
            return self._as_narrow_as_with_fewer() or self._narrowed()
        except _NotConverged:
            return None

    def _as_narrow_as_with_fewer(self) -> Parabola | None:
        """A parabola as narrow as that with fewer harmonics; None where either is too rough."""
        if (of_fewer := self._fewer) is None or (fewer := of_fewer._parabola) is None:
            return None
        if of_fewer._distance(fewer) > self._search.width:
            return None
        if (own := self._around_peak(self.first_phase, fewer.spread)) is None:
            return None
        # how far vertices converge with the spread is a matter of the curve, not of harmonics
        own = own.widened_by(fewer, fewer.distance)
        return own if self._distance(own) <= self._search.width else None

    def _distance(self, parabola: Parabola) -> float:
        """By how much a vertex may be off [rad], by roughness too."""
        sharpness = max(parabola.sharpness, _FLATTEST)
        # three standard deviations of the vertex, by those of three amplitudes
        moved = 3 * self._roughness(parabola.vertex) / (np.sqrt(2) * parabola.spread * sharpness)
        return parabola.distance + float(min(moved, parabola.spread))

    def _narrowed(self) -> Parabola | None:
        """The parabola of the peak, its vertex within the width where it can be."""
        spread, width = self._search.spread, self._search.width
        best = self._around_peak(self.first_phase, spread)
        while best is not None and min(best.distance, spread) > width:
            spread /= self._search.narrowing
            try:
                parabola = self._around_peak(best.vertex, spread)
                if parabola is None:
                    break
                low, high = (self._log_amplitude(one.vertex) for one in (best, parabola))
            except _NotConverged:
                break
            # vertices converge with the spread at least, where amplitudes are not too rough for it
            distance = abs(parabola.vertex - best.vertex) / (self._search.narrowing - 1)
            if distance > best.distance and high < low:
                break
            best = parabola.widened_by(best, distance)
        return best

    def _around_peak(self, first: float, spread: float) -> Parabola | None:
        """The parabola uphill from a phase whose middle is the highest of its phases, or None."""
        moved = 0
        # the start is nearest to it
        self._solution(first)
        while abs(moved) * spread <= self._search.largest_turn:
            phases = first + spread * np.arange(moved - 1.0, moved + 2.0)
            below, at, above = (self._log_amplitude(phase) for phase in phases)
            if at >= max(below, above):
                w = [self._equations.log_frequency(self._solutions[phase]) for phase in phases]
                return Parabola.through(phases, np.array([below, at, above]), np.array(w))
            moved += 1 if above > below else -1
        return None

    def _roughness(self, phase: float) -> float:
        """Deviation of ln amplitudes near a phase from a smooth curve."""
        near = self._solutions.within(1.5 * self._search.spread, phase)
        at = (np.array(near) - phase) / self._search.spread
        own = deviation_from_polynomial(at, np.array([self._log_amplitude(x) for x in near]))
        if len(near) > 4 or self._fewer is None:
            return own
        # those with fewer harmonics are hardly smoother
        return max(own, self._fewer._roughness(phase))

    def _beside(self, phase: float) -> float:
        """The nearest known phase beside one, as far motions take long, beyond roughness."""
        away = np.array(self._solutions.within(1.5 * self._search.spread, phase)) - phase
        beyond = away[abs(away) > self._search.spread / 5]
        one = self._search.spread / self._search.narrowing
        return phase + float(min(beyond, key=abs, default=one))

    def _log_amplitude(self, phase: float) -> float:
        """Logarithm of the amplitude of the output point."""
        return self._log_amplitude_of(self._solution(phase))

    def _log_amplitude_of(self, y: Array) -> float:
        q, _ = self._equations.solution(y)
        return float(np.log(self._equations.output.value(q)))

    def _solution(self, phase: float) -> Array:
        """The solution at a phase."""
        if phase not in self._solutions:
            self._solutions[phase] = self._solve(phase)
        return self._solutions[phase]

    def _solve(self, phase: float) -> Array:
        for guess in self._guesses(phase):
            if (x := self._find(self._solver, guess, phase, self._start)) is not None:
                return x
        nearest = self._solutions.nearest(phase)
        if not nearest and self._search.smallest_step < _BESIDE:
            return self._from_beside(phase)
        if not nearest or abs(phase - nearest[0]) < self._search.smallest_step:
            raise _NotConverged
        # by a solution between
        self._solution((phase + nearest[0]) / 2)
        return self._solve(phase)

    def _from_beside(self, phase: float) -> Array:
        """The first solution by one beside the peak, where motions hardly depend on friction."""
        for beside in (phase + _BESIDE, phase - _BESIDE):
            if (x := self._find(self._solver, self._start, beside, self._start)) is not None:
                self._solutions[beside] = x
        if not self._solutions:
            raise _NotConverged
        return self._solve(phase)

    def _find(self, solver: NewtonKrylov, guess: Array, phase: float, near: Array) -> Array | None:
        """The solution by a guess; None without one at a frequency near that of another."""
        x, _, _, converged, *_ = solver.solve(guess, phase)
        moved = abs(self._equations.log_frequency(x - near))
        # other resonances have the same phases
        return x if converged and moved <= self._search.largest_distance else None

    def _guesses(self, phase: float) -> Iterator[Array]:
        """By the change with fewer harmonics, between known solutions, the nearest, or the start.

        Three solutions with these harmonics tell more than those with fewer.
        """
        nearest = self._solutions.nearest(phase)
        if not nearest:
            yield self._start
            return
        near = self._solutions[nearest[0]]
        fewer, room = self._fewer, self._search.spread / 2
        if len(nearest) < 3 and fewer is not None and fewer._solutions.span(phase, room):
            of_fewer = (fewer._solutions.between(one) for one in (phase, nearest[0]))
            there, here = (self._equations.of_fewer(fewer._equations, y) for y in of_fewer)
            yield near + there - here
        elif len(nearest) > 1:
            yield self._solutions.between(phase)
        yield near


class _NotConverged(Exception):
    """The corrector did not converge at a phase."""
