"""Figure of the motion at the peaks of a response: its time history and its spectrum."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from boltjoint.harmonics import Components
from boltjoint.names import REFERENCE
from boltjoint.report.figures.style import (
    MM,
    REFERENCE_LINE,
    add_legends,
    figure_style,
    level_colours,
    method_label,
)

#: samples of the period, for a smooth line
_SAMPLES = 512
#: amplitude over that of the first harmonic down to which the axis goes: below are tolerances of
#: solutions, and rounding where harmonics vanish by symmetry
_LEAST = 1e-8
_HARMONIC_MARK: Mapping[str, Any] = {"marker": "o", "markersize": 3.5}


class PeakMotion(NamedTuple):
    """Motion of the output point at a peak: frequency [Hz], and its components [m]."""

    frequency: float
    components: Components
    displacement: NDArray[np.float64]

    @property
    def first(self) -> float:
        """Amplitude of the first harmonic [m]."""
        places = [self.components.sin(), self.components.cos()]
        return float(np.linalg.norm(self.displacement[places]))

    def history(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Fractions of the period, with its end, and displacements over the first harmonic."""
        over = self.displacement @ self.components.at_samples(_SAMPLES) / self.first
        return np.linspace(0, 1, _SAMPLES + 1), np.append(over, over[0])

    def spectrum(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Numbers of the harmonics that there are, and their amplitudes over the first."""
        squared = np.zeros(self.components.highest + 1)
        np.add.at(squared, self.components.number, self.displacement**2)
        number = np.flatnonzero(squared)
        return number, np.sqrt(squared[number]) / self.first


def motions_at_peaks(
    response: xr.Dataset, mode: NDArray[np.float64]
) -> tuple[list[PeakMotion | None], str]:
    """Motion of the output point at the peak of each level, and which peak it is.

    Of the peaks with all harmonics, where the response has their motion, else of its own; None of a
    level without such a peak, and of all where there is one harmonic, whose motions are sines.

    Parameters
    ----------
    response, mode
        As for ``plot_peak_motions``.
    """
    if "peak_motion_converged" in response:
        components = Components(response["output_component"].to_numpy().tolist())
        converged = response["peak_motion_converged"].transpose("force", "output_component")
        frequencies = response["peak_frequency_converged"].to_numpy().tolist()
        known = [
            PeakMotion(frequency, components, displacement) if np.isfinite(frequency) else None
            for frequency, displacement in zip(frequencies, converged.to_numpy(), strict=True)
        ]
        return known, "peak with all harmonics"
    # it takes long to import
    from boltjoint.dynamics.balance.periodic_motion import motion_at_peak

    components = Components(response["component"].to_numpy().tolist())
    motions: list[PeakMotion | None] = []
    for level, peak in zip(
        response["force_level"].to_numpy(), response["peak_frequency"].to_numpy(), strict=True
    ):
        has_motion = np.isfinite(peak) and components.highest > 1
        at_peak = motion_at_peak(response, level) if has_motion else None
        if at_peak is None:
            motions.append(None)
        else:
            frequency, motion = at_peak
            motions.append(PeakMotion(frequency, components, motion.modal_coordinate @ mode))
    return motions, "peak" if components.highest > 1 else "peak with all harmonics"


@figure_style
def plot_peak_motions(response: xr.Dataset, mode: NDArray[np.float64]) -> Figure:
    """Motion of the output point at the peak of each level: over a period, and by harmonic.

    Both are over the amplitude of the first harmonic, which stands in the legend. The harmonic 0
    is the mean, where motions have one.

    Parameters
    ----------
    response
        ``response.nc`` of the node-to-node joint in linear modes, with several harmonics or with
        the motion of its converged peaks.
    mode
        Modes at the output point [kg^-1/2], shape (modes,).

    Returns
    -------
    Figure
        Time history above, spectrum below.
    """
    motions, what = motions_at_peaks(response, mode)
    levels, unit = response["force_level"].to_numpy(), response["force_level"].attrs["units"]
    labels = [f"{level:g} {unit}" for level in levels]
    figure = Figure(figsize=(8, 6.4), layout="constrained")
    history, spectrum = figure.subplots(2)
    for place, (colour, motion) in enumerate(zip(level_colours(levels.size), motions, strict=True)):
        if motion is None:
            labels[place] += "\nno such peak found"
            continue
        line = {"color": colour, "label": labels[place], **REFERENCE_LINE}
        history.plot(*motion.history(), **line)
        spectrum.plot(*motion.spectrum(), **line, **_HARMONIC_MARK)
        labels[place] += f"\n{motion.frequency:.1f} Hz, {MM * motion.first:.3g} mm"
    history.set(xlabel="time / period of the excitation", xlim=(0, 1))
    history.set_ylabel("displacement /\nfirst-harmonic amplitude")
    spectrum.set(xlabel="harmonic", yscale="log")
    spectrum.set_ylabel("amplitude /\nfirst-harmonic amplitude")
    spectrum.set_ylim(bottom=max(_LEAST, spectrum.get_ylim()[0]))
    spectrum.xaxis.set_major_locator(MaxNLocator(integer=True))
    for axes in (history, spectrum):
        axes.grid(True)
    models = {method_label(*REFERENCE): REFERENCE_LINE}
    add_legends(history, models, f"level and {what}", labels)
    return figure
