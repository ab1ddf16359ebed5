"""Figure of the motion at the peaks of a response: its time history and its spectrum."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

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

if TYPE_CHECKING:
    from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion

#: samples of the period, for a smooth line
_SAMPLES = 512
#: amplitude over that of the first harmonic down to which the axis goes: below are tolerances of
#: solutions, and rounding where harmonics vanish by symmetry
_LEAST = 1e-8
_HARMONIC_MARK: Mapping[str, Any] = {"marker": "o", "markersize": 3.5}


@figure_style
def plot_peak_motions(response: xr.Dataset, mode: NDArray[np.float64]) -> Figure:
    """Motion of the output point at the peak of each level: over a period, and by harmonic.

    Both are over the amplitude of the first harmonic, which stands in the legend. The harmonic 0
    is the mean, where motions have one.

    Parameters
    ----------
    response
        ``response.nc`` of the node-to-node joint in linear modes, with several harmonics.
    mode
        Modes at the output point [kg^-1/2], shape (modes,).

    Raises
    ------
    ValueError
        If the response has one harmonic: its motions are sines.
    """
    # it takes long to import
    from boltjoint.dynamics.balance.periodic_motion import motion_at_peak

    if Components(response["component"].to_numpy().tolist()).highest == 1:
        raise ValueError("the response has one harmonic: its motions are sines")
    levels, unit = response["force_level"].to_numpy(), response["force_level"].attrs["units"]
    labels = [f"{level:g} {unit}" for level in levels]
    figure = Figure(figsize=(8, 6.4), layout="constrained")
    history, spectrum = figure.subplots(2)
    for place, colour in enumerate(level_colours(levels.size)):
        at_peak = motion_at_peak(response, levels[place])
        if at_peak is None or np.isnan(response["peak_frequency"][place]):
            labels[place] += "\nno peak found"
            continue
        frequency, motion = at_peak
        first = abs(motion.amplitude(mode))
        line = {"color": colour, "label": labels[place], **REFERENCE_LINE}
        history.plot(*_time_history(motion, mode / first), **line)
        spectrum.plot(*_spectrum(motion, mode / first), **line, **_HARMONIC_MARK)
        labels[place] += f"\n{frequency:.1f} Hz, {MM * first:.3g} mm"
    history.set(xlabel="time / period of the excitation", xlim=(0, 1))
    history.set_ylabel("displacement /\nfirst-harmonic amplitude")
    spectrum.set(xlabel="harmonic", yscale="log")
    spectrum.set_ylabel("amplitude /\nfirst-harmonic amplitude")
    spectrum.set_ylim(bottom=max(_LEAST, spectrum.get_ylim()[0]))
    spectrum.xaxis.set_major_locator(MaxNLocator(integer=True))
    for axes in (history, spectrum):
        axes.grid(True)
    add_legends(history, {method_label(*REFERENCE): REFERENCE_LINE}, "level and peak", labels)
    return figure


def _time_history(
    motion: "PeriodicMotion", mode: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fractions of the period, with its end, and the displacement of a point with these modes."""
    displacement = motion.in_time(_SAMPLES) @ mode
    return np.linspace(0, 1, _SAMPLES + 1), np.append(displacement, displacement[0])


def _spectrum(
    motion: "PeriodicMotion", mode: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Numbers of the harmonics that a point with these modes moves in, and their amplitudes."""
    components = Components(motion.components)
    squared = np.zeros(components.highest + 1)
    np.add.at(squared, components.number, (motion.modal_coordinate @ mode) ** 2)
    number = np.flatnonzero(squared)
    return number, np.sqrt(squared[number])
