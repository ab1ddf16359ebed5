"""Error bars of peaks, and peaks with as many harmonics as change nothing in result files."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.dataset import quantities, quantity
from boltjoint.dynamics.balance.periodic_motion import Superharmonic
from boltjoint.dynamics.response.harmonic_convergence import PeakSequence

Array = NDArray[np.float64]


class ConvergedPeak(NamedTuple):
    """The peaks of a force level, with the truncation errors and a superharmonic of the last.

    ``truncation_error`` of frequency and amplitude, relative; not a number where no peak with more
    harmonics than the first is found, or no motion with further ones or later samples near.
    ``inertia_error`` of both, by vectors of the basis that are no modes (``inertia_of_basis``); not
    a number where it is not known.
    """

    sequence: PeakSequence = PeakSequence(())
    truncation_error: tuple[float, float] = (np.nan, np.nan)
    superharmonic: Superharmonic | None = None
    inertia_error: tuple[float, float] = (np.nan, np.nan)

    @property
    def values(self) -> tuple[float, float, float]:
        """Frequency [Hz], amplitude [m] and highest harmonic; not a number without a peak."""
        if not self.sequence.has_more_harmonics:
            return np.nan, np.nan, np.nan
        last = self.sequence.peaks[-1]
        return last.frequency, last.amplitude, last.harmonics

    @property
    def extrapolated(self) -> "ConvergedPeak":
        """The same with the truncation error that the last change of the sequence tells.

        With what the phase of the last peak may be off, and what samples change. Not a number with
        fewer than two changes, or where what samples change is not known, as of peaks that are not
        at one phase.
        """
        frequency, amplitude = self.sequence.extrapolated_change.tolist()
        known = len(self.sequence.peaks) > 2
        if known and (located := self.sequence.peaks[-1].located) is not None:
            frequency += located.frequency_by_phase * located.distance + located.sampling_error[0]
            amplitude += located.amplitude_error + located.sampling_error[1]
        return self._replace(truncation_error=(frequency, amplitude) if known else (np.nan, np.nan))


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
        ``peak_amplitude_converged_error`` hold the truncation error of the converged peak, that by
        inertia of its basis, and what is estimated of its model; ``peak_frequency_error`` and
        ``peak_amplitude_error`` hold the difference of the response's own peak from it too, over
        the smaller of both.
    """
    errors = {}
    for what in ("frequency", "amplitude"):
        bar = error_bar(converged, what)
        meaning = f"error bar of peak_{what}_converged, relative"
        errors[f"peak_{what}_converged_error"] = quantity("force", bar, "1", meaning)
        own = error_bar(converged, what, response[f"peak_{what}"].to_numpy())
        meaning = f"error bar of peak_{what}, relative"
        errors[f"peak_{what}_error"] = quantity("force", own, "1", meaning)
    return response.merge(converged).assign(errors)


def error_bar(
    converged: xr.Dataset, what: Literal["frequency", "amplitude"], peak: Array | None = None
) -> Array:
    """Relative error bars of converged peaks, or of other peaks that they are better than.

    Parameters
    ----------
    converged
        Converged peaks and each part of their errors: of truncation and inertia; of basis and
        weights for all of them, if these are to count.
    what
        Frequency or amplitude.
    peak
        Other peaks, of the shape of the converged ones: their difference counts too, over the
        smaller of both, so that the bar holds it over either.
    """
    bar = 1 + converged[f"peak_{what}_truncation_error"].to_numpy()
    bar = bar * (1 + np.asarray(converged.get(f"peak_{what}_inertia_error", 0.0)))
    for of in ("basis", "weights"):
        estimate = float(converged.get(f"{of}_{what}_error", 0.0))
        # what is not estimated is no part of the bar, and told apart from it
        bar = bar * (1 + (0.0 if np.isnan(estimate) else estimate))
    if peak is not None:
        ratio = peak / converged[f"peak_{what}_converged"].to_numpy()
        bar = bar * np.maximum(ratio, 1 / ratio)
    return np.asarray(bar - 1, float)


def converged_peaks_to_dataset(peaks: Sequence[ConvergedPeak], output_mode: Array) -> xr.Dataset:
    """Peak sequences of the force levels as ``response.nc`` holds them.

    Parameters
    ----------
    peaks
        Of each force level.
    output_mode
        Modes at the output point [kg^-1/2], shape (modes,).

    Returns
    -------
    Dataset
        As of ``converged_peaks.converge_peaks``.
    """
    tried = sorted({peak.harmonics for at in peaks for peak in at.sequence.peaks})
    by_harmonics = np.full((2, len(peaks), len(tried)), np.nan)
    for place, (sequence, *_) in enumerate(peaks):
        for peak in sequence.peaks:
            at = place, tried.index(peak.harmonics)
            by_harmonics[:, *at] = peak.frequency, peak.amplitude
    converged = np.array([at.values for at in peaks])
    errors = np.array([at.truncation_error for at in peaks])
    of_inertia = np.array([at.inertia_error for at in peaks])
    by_inertia = "by inertia in further harmonics of vectors that are no modes"
    none = Superharmonic(0, np.nan, 0.0)
    of_superharmonic = np.array([at.superharmonic or none for at in peaks])
    of_all = "with as many harmonics as change nothing"
    of_forces = (
        ("peak_frequency_converged", converged[:, 0], "Hz", f"peak {of_all}"),
        ("peak_amplitude_converged", converged[:, 1], "m", f"its amplitude {of_all}"),
        ("peak_harmonics", converged[:, 2], "1", "highest of these harmonics"),
        ("peak_frequency_truncation_error", errors[:, 0], "1", "of the converged peak"),
        ("peak_amplitude_truncation_error", errors[:, 1], "1", "of its amplitude"),
        ("peak_frequency_inertia_error", of_inertia[:, 0], "1", f"of that peak, {by_inertia}"),
        ("peak_amplitude_inertia_error", of_inertia[:, 1], "1", f"of its amplitude, {by_inertia}"),
        ("superharmonic_order", of_superharmonic[:, 0], "1", "harmonic in resonance, 0 if none"),
        ("superharmonic_frequency", of_superharmonic[:, 1], "Hz", "resonance of that harmonic"),
        ("superharmonic_share", of_superharmonic[:, 2], "1", "that motion over the first harmonic"),
    )
    what = "with the harmonics up to that number"
    return xr.Dataset(
        quantities(
            (name, "force", values, unit, meaning) for name, values, unit, meaning in of_forces
        )
        | {
            "harmonic_peak_frequency": quantity(
                ("force", "harmonics"), by_harmonics[0], "Hz", f"peak {what}"
            ),
            "harmonic_peak_amplitude": quantity(
                ("force", "harmonics"), by_harmonics[1], "m", f"amplitude of the peak {what}"
            ),
        },
        coords={"harmonics": quantity("harmonics", tried, "1", "highest harmonic")},
    ).assign(_motions(peaks, output_mode))


def _motions(peaks: Sequence[ConvergedPeak], output_mode: Array) -> dict[str, xr.Variable]:
    """Motion of the output point at the converged peaks, by component; nothing without any."""
    last = [
        at.sequence.peaks[-1].motion if at.sequence.has_more_harmonics else None for at in peaks
    ]
    motions = [motion for motion in last if motion is not None]
    if not motions:
        return {}
    components = max((motion.components for motion in motions), key=len)
    moved = [
        np.full(len(components), np.nan)
        if motion is None
        else motion.in_components(components) @ output_mode
        for motion in last
    ]
    meaning = "motion of the output point at peak_frequency_converged"
    return {
        "output_component": xr.Variable("output_component", np.array(components, dtype=object)),
        "peak_motion_converged": quantity(("force", "output_component"), moved, "m", meaning),
    }
