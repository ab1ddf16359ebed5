"""Peaks of responses with as many harmonics as change nothing: what one harmonic leaves out.

From a peak of one harmonic, peaks with more are sought one after another, each from the one before,
until two successive changes are below a tolerance. Their truncation error is what the harmonics
left out change (``left_out_harmonics``).
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, damping_of_attributes
from boltjoint.dataset import quantity
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion, motion_at_peak
from boltjoint.dynamics.balance.superharmonics import Superharmonic, find_superharmonic
from boltjoint.dynamics.response.left_out_harmonics import (
    LeftOutHarmonics,
    change_by_left_out_harmonics,
)
from boltjoint.dynamics.response.phase_resonance import LocatedPeak, PeakSearch, PhaseResonance
from boltjoint.friction.aft import AlternatingFrequencyTime, without_sampling
from boltjoint.friction.element_law import ElementLaw
from boltjoint.joint.model import Joint
from boltjoint.options import Options

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


class _Converged(NamedTuple):
    """The peaks of a force level, with the truncation errors and a superharmonic of the last."""

    sequence: PeakSequence
    truncation_error: tuple[float, float]
    superharmonic: Superharmonic | None


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
    known = motion.components.highest
    amplitude = abs(motion.amplitude(joint.response_mode))
    given = HarmonicPeak(known, frequency, amplitude, motion)
    sequence, resonances = PeakSequence((given,)), []
    for highest in options.harmonics:
        if highest <= known:
            continue
        last, fewer = sequence.peaks[-1], resonances[-1] if resonances else None
        law = AlternatingFrequencyTime(joint.law, **options.sampling(highest))
        balance = HarmonicBalance(replace(joint, law=law), damping, force)
        resonance = PhaseResonance(balance, last.frequency, last.motion, fewer=fewer)
        located = resonance.peak(narrowed=False)
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


def converge_peaks(
    joint: Joint,
    response: xr.Dataset,
    options: HarmonicConvergence = HarmonicConvergence(),
    left_out: LeftOutHarmonics = LeftOutHarmonics(),
) -> xr.Dataset:
    """The peaks of a response with as many harmonics as change nothing.

    Parameters
    ----------
    joint, response
        A joint and its ``response.nc``.
    options
        Numbers of harmonics and tolerances.
    left_out
        How their truncation errors are estimated.

    Returns
    -------
    Dataset
        By ``force``: ``peak_frequency_converged`` [Hz], ``peak_amplitude_converged`` [m] and
        ``peak_harmonics``; ``peak_frequency_truncation_error`` and
        ``peak_amplitude_truncation_error``, relative: beyond the tolerances where the most
        harmonics do not suffice; not a number where the response has no peak, fewer than two with
        more harmonics are found, or its law has no elements that can be followed in time.
        ``superharmonic_order``, 0 without one, ``superharmonic_frequency`` [Hz] and
        ``superharmonic_share`` (``balance.superharmonics``). By ``force`` and ``harmonics``, the
        peaks on the way: ``harmonic_peak_frequency`` [Hz] and ``harmonic_peak_amplitude`` [m].

    Raises
    ------
    ValueError
        If joint or response are of another kind.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("response", response, xr.Dataset)
    joint = replace(joint, law=without_sampling(joint.law))
    found = [_Converged(PeakSequence(()), (np.nan, np.nan), None)]
    found *= response.sizes["force"]
    if isinstance(joint.law, ElementLaw):
        joint, damping = joint.distinct, damping_of_attributes(response.attrs)
        for place, force in enumerate(response["force_level"].to_numpy()):
            if np.isfinite(response["peak_frequency"][place]):
                peak = motion_at_peak(response, force)
                sequence = converge_peak(joint, *peak, force, damping, options)
                balance = HarmonicBalance(joint, damping, force)
                found[place] = _judge(sequence, balance, options, left_out)
    return _dataset(found)


def _judge(
    sequence: PeakSequence,
    balance: HarmonicBalance,
    options: HarmonicConvergence,
    left_out: LeftOutHarmonics,
) -> _Converged:
    """Truncation errors of a peak sequence, and whether a harmonic of its last is in resonance.

    What the search of the peak left is added: its distance from the peak, and its tolerance.
    """
    if not sequence.has_more_harmonics:
        return _Converged(sequence, (np.nan, np.nan), None)
    last = sequence.peaks[-1]
    if not sequence.converged:
        force, most = balance.excitation_force, last.harmonics
        logger.warning(
            "%g N: the peak still changes by more than the tolerances with %d harmonics, the most "
            "that are tried: its error bar is wider",
            force,
            most,
        )
    law = AlternatingFrequencyTime(balance.joint.law, **options.sampling(last.harmonics))
    balance = replace(balance, joint=replace(balance.joint, law=law))
    change = change_by_left_out_harmonics(balance, last.motion, last.frequency, left_out)
    frequency, amplitude = left_out.safety * change + sequence.extrapolated_change
    frequency += last.located.frequency_error(change[1])
    amplitude += last.located.amplitude_error + PeakSearch().tolerance
    q, w = last.motion.in_components(law.components), 2 * np.pi * last.frequency
    jacobian = balance.residual_and_jacobian(q.ravel(), w)[1]()
    superharmonic = find_superharmonic(balance, jacobian, last.motion, last.frequency)
    return _Converged(sequence, (frequency, amplitude), superharmonic)


def add_converged_peaks(response: xr.Dataset, converged: xr.Dataset) -> xr.Dataset:
    """A response with the converged peaks of its joint, their error bars and those of its own.

    Parameters
    ----------
    response
        ``response.nc`` in any coordinates.
    converged
        As from ``converge_peaks``, for the same joint, resonance and forces; with the estimated
        errors of basis and weights (``joint.io.model_errors``), if they are to count.

    Returns
    -------
    Dataset
        Both, and relative error bars. ``peak_frequency_converged_error`` and
        ``peak_amplitude_converged_error`` hold the truncation error of the converged peak and what
        is estimated of its model; ``peak_frequency_error`` and ``peak_amplitude_error`` hold the
        difference of the response's own peak from it too, over the smaller of both.
    """
    errors = {}
    for what in ("frequency", "amplitude"):
        ratio = (response[f"peak_{what}"] / converged[f"peak_{what}_converged"]).to_numpy()
        bar = 1 + converged[f"peak_{what}_truncation_error"].to_numpy()
        for of in ("basis", "weights"):
            estimate = float(converged.get(f"{of}_{what}_error", 0.0))
            # what is not estimated is no part of the bar, and told apart from it
            bar = bar * (1 + (0.0 if np.isnan(estimate) else estimate))
        meaning = f"error bar of peak_{what}_converged, relative"
        errors[f"peak_{what}_converged_error"] = quantity("force", bar - 1, "1", meaning)
        # over the smaller of both, so that it holds the difference over either
        own = np.maximum(ratio, 1 / ratio) * bar - 1
        meaning = f"error bar of peak_{what}, relative"
        errors[f"peak_{what}_error"] = quantity("force", own, "1", meaning)
    return response.merge(converged).assign(errors)


def _dataset(found: Sequence[_Converged]) -> xr.Dataset:
    """Peak sequences of the force levels as ``response.nc`` holds them."""
    tried = sorted({peak.harmonics for each in found for peak in each.sequence.peaks})
    by_harmonics = np.full((2, len(found), len(tried)), np.nan)
    converged = np.full((len(found), 3), np.nan)
    for place, (sequence, *_) in enumerate(found):
        for peak in sequence.peaks:
            at = place, tried.index(peak.harmonics)
            by_harmonics[:, *at] = peak.frequency, peak.amplitude
        if sequence.has_more_harmonics:
            last = sequence.peaks[-1]
            converged[place] = last.frequency, last.amplitude, last.harmonics
    errors = np.array([each.truncation_error for each in found])
    none = Superharmonic(0, np.nan, 0.0)
    of_superharmonic = np.array([each.superharmonic or none for each in found])
    of_all = "with as many harmonics as change nothing"
    of_forces = (
        ("peak_frequency_converged", converged[:, 0], "Hz", f"peak {of_all}"),
        ("peak_amplitude_converged", converged[:, 1], "m", f"its amplitude {of_all}"),
        ("peak_harmonics", converged[:, 2], "1", "highest of these harmonics"),
        ("peak_frequency_truncation_error", errors[:, 0], "1", "of the converged peak"),
        ("peak_amplitude_truncation_error", errors[:, 1], "1", "of its amplitude"),
        ("superharmonic_order", of_superharmonic[:, 0], "1", "harmonic in resonance, 0 if none"),
        ("superharmonic_frequency", of_superharmonic[:, 1], "Hz", "resonance of that harmonic"),
        ("superharmonic_share", of_superharmonic[:, 2], "1", "that motion over the first harmonic"),
    )
    what = "with the harmonics up to that number"
    return xr.Dataset(
        {name: quantity("force", *row) for name, *row in of_forces}
        | {
            "harmonic_peak_frequency": quantity(
                ("force", "harmonics"), by_harmonics[0], "Hz", f"peak {what}"
            ),
            "harmonic_peak_amplitude": quantity(
                ("force", "harmonics"), by_harmonics[1], "m", f"amplitude of the peak {what}"
            ),
        },
        coords={"harmonics": quantity("harmonics", tried, "1", "highest harmonic")},
    )
