"""Peaks of a resonance with more and more harmonics, until these change nothing.

From a peak of few harmonics, peaks with more are sought one after another, each from the one
before, until two successive changes are below a tolerance.

What the harmonics that a peak leaves out would change is the estimate of its truncation error. The
contact forces of a motion with H harmonics have harmonics beyond H, which nothing balances. The
motion with several times as many, sought from it at the same phase of the output point, holds the
response of the structure with its contact to them. At a peak the amplitude does not change with
the phase to first order, so that its change at that phase is the one of the peak.

It has to be solved. Few corrections of the motion, by GMRES with a preconditioner that leaves the
harmonics beyond H uncoupled, told a change of 1e-5 where it is 4.6e-3: their residual stayed at
half of the force, as a harmonic beyond H was near a mode of the contact.

Where twice as many harmonics are solved, the next H of them may be near such a mode: 66 harmonics
changed a peak of 33 by 1.2e-4 that 99 change by 1.1e-3. Their acceleration is predicted from the
forces left over, each harmonic by itself; where it does not fall, they are solved too.

References
----------
A. Grolet, F. Thouverez: On a new harmonic selection technique for harmonic balance method.
Mechanical Systems and Signal Processing 30 (2012) 43-60.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.balance.balance_equations import PhaseEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response.phase_resonance import LocatedPeak, PeakSearch, PhaseResonance
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.harmonics import Components
from boltjoint.joint.model import Joint
from boltjoint.options import Options
from boltjoint.solvers.equations import StepControl
from boltjoint.solvers.newton import NewtonKrylov

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LeftOutHarmonics(Options):
    """The motion at a peak with harmonics that it leaves out.

    Parameters
    ----------
    times
        Highest harmonic, over that of the peak: twice always, more where the accelerations of the
        next harmonics are predicted not to fall.
    finer
        Time samples a period over those of the peak, at least, so that the change holds their error
        too, which falls with their square.
    tolerance, iterations
        Residual of the equations over the force, and corrections at most; beyond them fewer
        harmonics are added at once.
    smallest_fall
        Predicted acceleration of the next harmonics over that of the last as many, from which the
        next are solved too. The prediction leaves couplings of harmonics out and was too low by a
        factor of up to six; motion without resonances, by forces that fall with the square of the
        harmonic, has a third.
    safety
        Factor of the largest change, for what further harmonics would add: the change by three
        times the harmonics was up to 2.5 times that by twice as many, on three assemblies of two to
        five bolts.
    """

    times: int = 3
    finer: int = 2
    tolerance: float = 1e-5
    iterations: int = 30
    smallest_fall: float = 0.5
    safety: float = 3.0

    def __post_init__(self) -> None:
        """Refuse options without further harmonics."""
        checks.whole("times", self.times, at_least=2)
        for name in ("finer", "iterations"):
            checks.whole(name, getattr(self, name), at_least=1)
        for name in ("tolerance", "smallest_fall", "safety"):
            checks.number(name, getattr(self, name), above=0)


def change_by_left_out_harmonics(
    balance: HarmonicBalance,
    motion: PeriodicMotion,
    frequency: float,
    options: LeftOutHarmonics = LeftOutHarmonics(),
) -> Array:
    """Relative changes of frequency and amplitude of a peak with further harmonics.

    Parameters
    ----------
    balance
        In linear modes, with AFT in the harmonics of the motion.
    motion, frequency
        The peak, and its frequency [Hz].
    options
        Harmonics, and how they are solved.

    Returns
    -------
    ndarray
        Shape (2,), without sign: the largest; not a number where the motion is not found.
    """
    law = checks.instance("law of the balance", balance.joint.law, AlternatingFrequencyTime)
    mode = balance.joint.response_mode
    before = np.array([frequency, abs(motion.amplitude(mode))])
    largest = np.zeros(2)
    for times in range(2, options.times + 1):
        highest = times * law.harmonics
        samples = max(options.finer * law.samples, 4 * highest)
        extended = AlternatingFrequencyTime(law.elements, highest, samples)
        more = replace(balance, joint=replace(balance.joint, law=extended))
        if times > 2 and _fall(more, motion, frequency, law.harmonics) < options.smallest_fall:
            break
        found = _with_more_harmonics(more, motion, frequency, options)
        if found is None:
            return np.full(2, np.nan)
        motion, frequency = found
        after = np.array([frequency, abs(motion.amplitude(mode))])
        largest = np.maximum(largest, abs(after / before - 1))
    return largest


def _with_more_harmonics(
    balance: HarmonicBalance, motion: PeriodicMotion, frequency: float, options: LeftOutHarmonics
) -> tuple[PeriodicMotion, float] | None:
    """A motion with the harmonics of a balance at the same phase, and its frequency [Hz].

    Where corrections do not converge, fewer harmonics are added at once: 33 at once took 77
    corrections on three bolts, from residuals that grew to a hundred times the force.
    """
    control = StepControl(tolerance=options.tolerance, maximum_iterations=options.iterations)
    law = checks.instance("law of the balance", balance.joint.law, AlternatingFrequencyTime)
    highest = Components(motion.components).highest
    added = law.harmonics - highest
    while highest < law.harmonics:
        partial = replace(law, harmonics=min(highest + added, law.harmonics))
        fewer = replace(balance, joint=replace(balance.joint, law=partial))
        equations, y, phase = PhaseEquations.near(fewer, motion, frequency)
        solution = NewtonKrylov(equations, control).solve(y, phase)
        if solution.converged:
            x, w = equations.solution(solution.x)
            motion = PeriodicMotion(fewer.components, fewer.components.rows(x))
            highest, frequency = partial.harmonics, w / (2 * np.pi)
        elif added == 1:
            return None
        else:
            added //= 2
    return motion, frequency


def _fall(balance: HarmonicBalance, motion: PeriodicMotion, frequency: float, count: int) -> float:
    """Predicted acceleration of harmonics beyond those of a motion, over that of its last ones.

    Each further harmonic is moved by the forces of the motion alone, against the structure and the
    mean stiffness of the contact, as slip of the motion leaves it.

    Parameters
    ----------
    balance
        With the further harmonics.
    motion, frequency
        Without them, and its frequency [Hz].
    count
        How many harmonics are its last.
    """
    components, w = balance.components, 2 * np.pi * frequency
    q = motion.in_components(components)
    force, tangent = balance.contact.force_and_tangent(q.ravel(), w)
    force = components.rows(force)
    _, sin, cos = components.harmonics[-1]
    modes = q.shape[1]
    contact = np.empty((modes, modes), dtype=complex)
    for mode in range(modes):
        unit = np.zeros_like(q)
        unit[sin, mode] = 1.0
        along = components.rows(tangent.along(unit.ravel()))
        contact[:, mode] = along[sin] + 1j * along[cos]
    last = Components(motion.components).highest
    squares = np.zeros(2)
    for h, sin, cos in components.harmonics:
        if h > last:
            inertia = (h * w) ** 2 * np.eye(modes)
            stiffness = balance.complex_stiffness(w, h) + contact - inertia
            amplitude = np.linalg.solve(stiffness, force[sin] + 1j * force[cos])
        else:
            amplitude = q[sin] + 1j * q[cos]
        if h > last - count:
            squares[int(h > last)] += np.linalg.norm(h**2 * amplitude) ** 2
    return float(np.sqrt(squares[1] / squares[0])) if squares[0] else np.inf


logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class HarmonicConvergence(Options):
    """Numbers of harmonics that are tried for a peak, and when they are enough.

    Parameters
    ----------
    harmonics
        Highest harmonics tried, ascending, nearly doubled from one to the next: neighbours may
        agree by chance. With 5 and 7 too, error bars of two of seven peaks of
        ``three_bolt_constant`` did not hold those of 49.
    amplitude_tolerance, frequency_tolerance
        The last is taken where it and the one before changed no more than that, relative. One
        small change may be chance: under variable normal load amplitudes of 9 and 17 harmonics
        within 0.4 % were followed by 1 % with 33. Peaks are as wide as their damping, so that a
        frequency moves less than an amplitude.
    samples, samples_per_harmonic
        Time samples a period: at least so many, and so many for each harmonic.

    Raises
    ------
    ValueError
        If the harmonics do not ascend, or a number is not positive.
    """

    harmonics: tuple[int, ...] = (3, 9, 17, 33)
    amplitude_tolerance: float = 5e-3
    frequency_tolerance: float = 5e-4
    samples: int = 256
    samples_per_harmonic: int = 16

    def __post_init__(self) -> None:
        """Refuse options with which nothing converges."""
        checks.numbers("harmonics", self.harmonics)
        if any(np.diff(self.harmonics) <= 0):
            raise ValueError("harmonics must ascend")
        for name in ("amplitude_tolerance", "frequency_tolerance"):
            checks.number(name, getattr(self, name), above=0)
        for name in ("samples", "samples_per_harmonic"):
            checks.whole(name, getattr(self, name), at_least=3)

    def up_to(self, highest: int) -> Self:
        """Without the numbers of harmonics above one; the least of them stays."""
        within = tuple(number for number in self.harmonics if number <= highest)
        return replace(self, harmonics=within or self.harmonics[:1])

    def sampling(self, harmonics: int) -> dict[str, int]:
        """Harmonics and time samples of AFT with a number of harmonics."""
        samples = max(self.samples, self.samples_per_harmonic * harmonics)
        return {"harmonics": harmonics, "samples": samples}


class HarmonicPeak(NamedTuple):
    """A peak with a number of harmonics: frequency [Hz], first-harmonic amplitude [m], motion.

    ``located`` by the phase of the output point; None of a peak that is given.
    """

    harmonics: int
    frequency: float
    amplitude: float
    motion: PeriodicMotion
    located: LocatedPeak | None = None

    def change_from(self, other: "HarmonicPeak") -> NDArray[np.float64]:
        """Relative change of frequency and amplitude from another peak, without sign."""
        return abs(
            np.array([self.frequency / other.frequency, self.amplitude / other.amplitude]) - 1
        )


class PeakSequence(NamedTuple):
    """Peaks found with more and more harmonics, and whether the last changed within tolerances."""

    peaks: tuple[HarmonicPeak, ...]
    converged: bool = False

    @property
    def has_more_harmonics(self) -> bool:
        """Whether a peak with more harmonics than the first is among them."""
        return len(self.peaks) > 1

    @property
    def extrapolated_change(self) -> NDArray[np.float64]:
        """Change of frequency and amplitude by further harmonics, extrapolated from the last.

        Motion by the forces of friction falls with the square of the harmonic at least. Zero with
        one peak beside the first, which may be that of an analytic law, not of as many samples.
        """
        if len(self.peaks) < 3:
            return np.zeros(2)
        before, last = self.peaks[-2:]
        ratio = (last.harmonics / before.harmonics) ** 2
        return last.change_from(before) / (ratio - 1)

    def changes_within(self, tolerances: tuple[float, float]) -> bool:
        """Whether the last two changes of frequency and amplitude are within tolerances.

        But that from the first: it may be the peak of an analytic law, not of as many samples.
        """
        last = list(pairwise(self.peaks[1:]))[-2:]
        changes = [after.change_from(before) for before, after in last]
        return len(changes) == 2 and bool(np.all(np.array(changes) <= tolerances))


def converge_peak(
    joint: Joint,
    frequency: float,
    motion: PeriodicMotion,
    force: float,
    damping: Damping | float,
    options: HarmonicConvergence = HarmonicConvergence(),
) -> PeakSequence:
    """The peaks near one of few harmonics, with more until they change by less than tolerances.

    Parameters
    ----------
    joint
        With the law of its elements.
    frequency, motion
        Frequency and motion of the peak with few harmonics [Hz].
    force
        Amplitude of the excitation [N].
    damping
        Damping of the structure; a number is a loss factor.
    options
        Numbers of harmonics and tolerances.

    Returns
    -------
    PeakSequence
        From the given peak on, without numbers of harmonics with which none is found.
    """
    checks.instance("options", options, HarmonicConvergence)
    tolerances = options.frequency_tolerance, options.amplitude_tolerance
    first = Components(motion.components).highest
    amplitude = abs(motion.amplitude(joint.response_mode))
    start = HarmonicPeak(first, frequency, amplitude, motion)
    sequence = PeakSequence((start,))
    resonances: list[PhaseResonance] = []
    for highest in options.harmonics:
        if highest <= first:
            continue
        last, fewer = sequence.peaks[-1], resonances[-1] if resonances else None
        law = AlternatingFrequencyTime(joint.contact.element_law, **options.sampling(highest))
        balance = HarmonicBalance(replace(joint, law=law), damping, force)
        resonance = PhaseResonance(balance, last.frequency, last.motion, fewer=fewer)
        located = resonance.peak(narrowed=False)
        if located is None:
            restarted = _restarted(balance, last)
            if restarted is not None:
                resonance, located = restarted, restarted.peak(narrowed=False)
        logger.info("%g N, %d harmonics: %s", force, highest, located and located.frequency)
        if located is None:
            continue
        resonances.append(resonance)
        sequence = PeakSequence((*sequence.peaks, _peak_with(highest, located, joint)))
        if sequence.changes_within(tolerances):
            sequence = _narrowed(sequence, resonances, joint)
            if sequence.changes_within(tolerances):
                return sequence._replace(converged=True)
    return _narrowed(sequence, resonances, joint)


def _restarted(balance: HarmonicBalance, peak: HarmonicPeak) -> PhaseResonance | None:
    """Motions near a peak with fewer harmonics, by one to which these are added a few at a time.

    None where there is none, or it is one of another resonance.
    """
    found = _with_more_harmonics(balance, peak.motion, peak.frequency, LeftOutHarmonics())
    if found is None:
        return None
    motion, frequency = found
    if abs(np.log(frequency / peak.frequency)) > PeakSearch().largest_distance:
        return None
    return PhaseResonance(balance, frequency, motion)


def _narrowed(
    sequence: PeakSequence, resonances: Sequence[PhaseResonance], joint: Joint
) -> PeakSequence:
    """With the last two peaks, whose change counts, located as well as they can be."""
    peaks = list(sequence.peaks)
    for place, resonance in zip((-1, -2), reversed(resonances), strict=False):
        located = resonance.peak()
        if located is not None:
            peaks[place] = _peak_with(peaks[place].harmonics, located, joint)
    return PeakSequence(tuple(peaks))


def _peak_with(harmonics: int, located: LocatedPeak, joint: Joint) -> HarmonicPeak:
    amplitude = abs(located.motion.amplitude(joint.response_mode))
    return HarmonicPeak(harmonics, located.frequency, amplitude, located.motion, located)
