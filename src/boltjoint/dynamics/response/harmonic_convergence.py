"""Peaks of a resonance with more and more harmonics, until these change nothing.

From a peak of few harmonics, peaks with more are sought one after another, each from the one
before, until two successive changes are below a tolerance.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response.amplitude_by_phase import LocatedPeak
from boltjoint.dynamics.response.left_out_harmonics import LeftOutHarmonics, with_more_harmonics
from boltjoint.dynamics.response.phase_resonance import PeakSearch, PhaseResonance
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.harmonics import Components
from boltjoint.joint.model import Joint
from boltjoint.options import CONVERGING, Options

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class HarmonicConvergence(Options):
    """Numbers of harmonics that are tried for a peak, and when they are enough.

    A study gives the tolerances and the samples (``config.numerical_options.Solver``).

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

    harmonics: tuple[int, ...] = CONVERGING
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
    """Peaks found with more and more harmonics, and whether the last changed within tolerances.

    ``resonance``: motions near the last; None with one peak.
    """

    peaks: tuple[HarmonicPeak, ...]
    converged: bool = False
    resonance: PhaseResonance | None = None

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
    *,
    at_one_phase: bool = False,
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
    at_one_phase
        Whether a peak is located with the fewest harmonics only, and the motion at its phase stands
        for those with more: in half of the time, within 2e-4 of the frequency and 4e-4 of the
        amplitude in 40 designs of ``three_bolt_uncertainty``, 6e-4 and 4e-4 in smaller joints.
        ``ConvergedPeak.extrapolated`` holds it where amplitudes are smooth over the phase.

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
        kept = _kept_phase(sequence, resonances) if at_one_phase else None
        locate = partial(_locate, kept=kept, solved=at_one_phase)
        located = locate(resonance)
        if located is None:
            restarted = _restarted(balance, last)
            if restarted is not None:
                resonance, located = restarted, locate(restarted)
        logger.info("%g N, %d harmonics: %s", force, highest, located and located.frequency)
        if located is None:
            continue
        resonances.append(resonance)
        sequence = PeakSequence((*sequence.peaks, _peak_with(highest, located, joint)))
        if sequence.changes_within(tolerances):
            if not at_one_phase:
                sequence = _solved(sequence, resonances, joint)
            if sequence.changes_within(tolerances):
                return sequence._replace(converged=True)
    return sequence if at_one_phase else _solved(sequence, resonances, joint)


def _restarted(balance: HarmonicBalance, peak: HarmonicPeak) -> PhaseResonance | None:
    """Motions near a peak with fewer harmonics, by one to which these are added a few at a time.

    None where there is none, or it is one of another resonance.
    """
    found = with_more_harmonics(balance, peak.motion, peak.frequency, LeftOutHarmonics())
    if found is None:
        return None
    motion, frequency, _ = found
    if abs(np.log(frequency / peak.frequency)) > PeakSearch().largest_distance:
        return None
    return PhaseResonance(balance, frequency, motion)


def _solved(
    sequence: PeakSequence, resonances: Sequence[PhaseResonance], joint: Joint
) -> PeakSequence:
    """With the last two peaks, whose change counts, solved at their phases."""
    peaks = list(sequence.peaks)
    for place, resonance in zip((-1, -2), reversed(resonances), strict=False):
        located = resonance.peak()
        if located is not None:
            peaks[place] = _peak_with(peaks[place].harmonics, located, joint)
    return PeakSequence(tuple(peaks), resonance=resonances[-1] if resonances else None)


def _kept_phase(sequence: PeakSequence, resonances: Sequence[PhaseResonance]) -> LocatedPeak | None:
    """The first located peak, with what its phase may be off with more harmonics; None without.

    That is by how far it is from the phase of the peak before, beside what it may be off itself.
    """
    located = sequence.peaks[1].located if sequence.has_more_harmonics else None
    if located is None:
        return None
    distance = located.distance + abs(located.phase - resonances[0].first_phase)
    error = located.amplitude_error + located.sharpness * distance**2 / 2
    return located._replace(distance=distance, amplitude_error=error)


def _locate(
    resonance: PhaseResonance, kept: LocatedPeak | None, *, solved: bool
) -> LocatedPeak | None:
    """The peak of motions near a resonance, or the one that stands for it at a kept phase."""
    if kept is None:
        located = resonance.peak(solved=solved)
        return resonance.with_sampling_error(located) if solved and located else located
    if (found := resonance.start()) is None:
        return None
    motion, frequency = found
    return kept._replace(frequency=frequency, motion=motion)


def _peak_with(harmonics: int, located: LocatedPeak, joint: Joint) -> HarmonicPeak:
    amplitude = abs(located.motion.amplitude(joint.response_mode))
    return HarmonicPeak(harmonics, located.frequency, amplitude, located.motion, located)
