"""Peaks of responses with as many harmonics as change nothing: what one harmonic leaves out.

From a peak of one harmonic, peaks with more are sought one after another, each from the one before,
until two successive ones differ by less than a tolerance.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from boltjoint import checks
from boltjoint.damping import Damping, damping_of_attributes
from boltjoint.dataset import quantity
from boltjoint.dynamics.harmonic_balance import parse_component
from boltjoint.dynamics.periodic_motion import PeriodicMotion, motion_at_peak
from boltjoint.dynamics.phase_resonance import find_peak
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.law import ElementLaw
from boltjoint.joint.model import Joint
from boltjoint.options import Options

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class HarmonicConvergence(Options):
    """Numbers of harmonics that are tried for a peak, and when they are enough.

    Parameters
    ----------
    harmonics
        Highest harmonics tried, ascending.
    amplitude_tolerance, frequency_tolerance
        Largest relative change of a peak between two of them at which the last is taken. Peaks are
        as wide as their damping, so that a frequency moves less than an amplitude.
    samples, samples_per_harmonic
        Time samples a period: at least so many, and so many for each harmonic.

    Raises
    ------
    ValueError
        If the harmonics do not ascend, or a number is not positive.
    """

    harmonics: tuple[int, ...] = (3, 5, 7, 9, 13, 17, 25, 33, 49)
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


class ConvergedPeak(NamedTuple):
    """Frequency [Hz], first-harmonic amplitude [m] and number of harmonics of a peak."""

    frequency: float
    amplitude: float
    harmonics: int


def converge_peak(
    joint: Joint,
    frequency: float,
    motion: PeriodicMotion,
    force: float,
    damping: Damping | float,
    options: HarmonicConvergence = HarmonicConvergence(),
) -> ConvergedPeak | None:
    """The peak near one of few harmonics, with as many as change it by less than the tolerances.

    Parameters
    ----------
    joint
        With the law of its elements.
    frequency, motion
        Of the peak with few harmonics [Hz].
    force
        Amplitude of the excitation [N].
    damping
        Of the structure; a number is a loss factor.
    options
        Numbers of harmonics and tolerances.

    Returns
    -------
    ConvergedPeak or None
        None where the numbers of harmonics do not suffice, or a peak is not found.
    """
    before: ConvergedPeak | None = None
    for highest in options.harmonics:
        samples = max(options.samples, options.samples_per_harmonic * highest)
        how = {"harmonics": highest, "samples": samples}
        found = find_peak(joint, frequency, force, damping, motion, **how)
        if found is None:
            continue
        frequency, motion = found
        amplitude = abs(motion.amplitude(joint.response_mode))
        peak = ConvergedPeak(frequency, amplitude, highest)
        if before is not None and _is_near(peak, before, options):
            return peak
        before = peak
    return None


def converge_peaks(
    joint: Joint,
    response: xr.Dataset,
    options: HarmonicConvergence = HarmonicConvergence(),
) -> xr.Dataset:
    """The peaks of a response with as many harmonics as change nothing.

    Parameters
    ----------
    joint, response
        A joint and its ``response.nc``.
    options
        Numbers of harmonics and tolerances.

    Returns
    -------
    Dataset
        By ``force``: ``peak_frequency_converged`` [Hz], ``peak_amplitude_converged`` [m] and
        ``peak_harmonics``; not a number where the response has no peak, its law has no elements
        that can be followed in time, or the harmonics do not suffice.

    Raises
    ------
    ValueError
        If joint or response are of another kind.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("response", response, xr.Dataset)
    if isinstance(joint.law, AlternatingFrequencyTime):
        joint = replace(joint, law=joint.law.elements)
    found: Sequence[ConvergedPeak | None] = [None] * response.sizes["force"]
    if isinstance(joint.law, ElementLaw):
        joint, damping = joint.distinct, damping_of_attributes(response.attrs)
        found = [
            _of_level(joint, response, place, damping, options)
            for place in range(response.sizes["force"])
        ]
    rows = np.array([each or (np.nan,) * 3 for each in found]).reshape(-1, 3)
    of_all = "with as many harmonics as change nothing"
    return xr.Dataset(
        {
            "peak_frequency_converged": quantity("force", rows[:, 0], "Hz", f"peak {of_all}"),
            "peak_amplitude_converged": quantity(
                "force", rows[:, 1], "m", f"its amplitude {of_all}"
            ),
            "peak_harmonics": quantity("force", rows[:, 2], "1", "highest of these harmonics"),
        }
    )


def _of_level(
    joint: Joint,
    response: xr.Dataset,
    place: int,
    damping: Damping,
    options: HarmonicConvergence,
) -> ConvergedPeak | None:
    """The converged peak under one of the forces."""
    force = float(response["force_level"][place])
    if not np.isfinite(response["peak_frequency"][place]):
        return None
    frequency, motion = motion_at_peak(response, force)
    if len(motion.components) > len(joint.law.components):
        known = max(parse_component(name)[1] for name in motion.components)
        options = replace(options, harmonics=tuple(h for h in options.harmonics if h >= known))
    found = converge_peak(joint, frequency, motion, force, damping, options)
    logger.info("%g N: with all harmonics %s", force, found)
    return found


def _is_near(peak: ConvergedPeak, before: ConvergedPeak, options: HarmonicConvergence) -> bool:
    return (
        abs(peak.amplitude / before.amplitude - 1) <= options.amplitude_tolerance
        and abs(peak.frequency / before.frequency - 1) <= options.frequency_tolerance
    )
