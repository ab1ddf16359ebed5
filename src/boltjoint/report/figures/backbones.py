"""Figures of backbones: frequency and damping, and microslip along them."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter
from numpy.typing import NDArray

from boltjoint.names import JointName
from boltjoint.report.figures.curves import LIMIT, LIMIT_LINE, peaks_on_backbone
from boltjoint.report.figures.style import (
    MM,
    figure_style,
    label_decades,
    level_colours,
)

#: amplitude over that limit at which axes end
_BEYOND = 3


@figure_style
def plot_backbones(
    backbones: Mapping[str, xr.Dataset], forces: Sequence[float], limit: float | None = None
) -> Figure:
    """Natural frequency and damping ratio over amplitude, by joint.

    Parameters
    ----------
    backbones
        ``backbone.nc`` by joint.
    forces
        Excitations [N] whose peaks are marked.
    limit
        Amplitude [mm] beyond which the model does not hold: the axes end at
        ``_BEYOND`` times that.
    """
    figure = Figure(figsize=(8, 6), layout="constrained")
    panels = figure.subplots(2, sharex=True)
    for (joint, backbone), colour in zip(
        backbones.items(), level_colours(len(backbones)), strict=True
    ):
        amplitude = backbone["response_amplitude"].to_numpy() * MM
        label = "\n".join([JointName(joint).label, *_isolated_branches(backbone)])
        peaks = np.array(list(peaks_on_backbone(backbone, forces).values()))
        for axes, name, scale in zip(
            panels, ("natural_frequency", "damping_ratio"), (1.0, 100.0), strict=True
        ):
            values = backbone[name].to_numpy() * scale
            axes.plot(amplitude, values, color=colour, linewidth=1.3, label=label)
            if peaks.size:
                at_peaks = np.interp(np.log(peaks), np.log(amplitude), values)
                axes.plot(peaks, at_peaks, "o", color=colour, markersize=4)
    panels[0].set_ylabel("natural frequency (Hz)")
    panels[1].set_ylabel("damping ratio (%)")
    panels[1].set_yscale("log")
    label_decades(panels[1])
    panels[1].set_xlabel("amplitude at the output point (mm)")
    for axes in panels:
        axes.set_xscale("log")
        axes.grid(True)
        if limit is not None:
            low, high = axes.get_xlim()
            if limit < high:
                axes.axvline(limit, color="0.4", label=LIMIT, **LIMIT_LINE)
                axes.set_xlim(low, min(high, _BEYOND * limit))
    panels[0].legend()
    return figure


def _isolated_branches(backbone: xr.Dataset) -> Iterator[str]:
    """Each range of excitation with an isolated branch, in words."""
    unit = backbone["isolated_from"].attrs["units"]
    for low, high in zip(backbone["isolated_from"], backbone["isolated_to"], strict=True):
        yield f"isolated branch from {float(low):.4g} to {float(high):.4g} {unit}"


#: dissipation over squared amplitude, over its maximum, from which on it is drawn: less is rounding
_DRAWN = 1e-5
_FIT_LINE: dict[str, Any] = {"linewidth": 5.0, "alpha": 0.35, "solid_capstyle": "butt", "zorder": 2}
_PEAK_MARK = {"marker": "o", "mec": "white", "mew": 0.6, "linestyle": "none", "markersize": 5.5}
#: power of smooth spheres (Mindlin), drawn where the fit is
_SPHERES = 3.0


class Peaks(NamedTuple):
    """Amplitude [m], frequency [Hz] and friction dissipation [J] at the peaks of responses."""

    amplitude: NDArray[np.float64]
    frequency: NDArray[np.float64]
    dissipation: NDArray[np.float64]


@figure_style
def plot_microslip(
    backbones: Mapping[str, xr.Dataset], table: pd.DataFrame, peaks: Mapping[str, Peaks]
) -> Figure:
    """Friction dissipation in a period and natural frequency over amplitude, in logarithmic axes.

    A broad pale line is the power law of microslip, with its power; dashed, the power 3 of smooth
    spheres from the same end. A dot is the peak of a response to a force.

    Parameters
    ----------
    backbones
        ``backbone.nc`` by joint.
    table
        As ``tabulate_microslip`` returns it.
    peaks
        Peaks of the responses in linear modes, by joint, as far as there are.
    """
    figure = Figure(figsize=(8, 7), layout="constrained")
    lost, resonance = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    fits = table.set_index("joint")
    colours = level_colours(len(backbones))
    for row, ((joint, backbone), colour) in enumerate(zip(backbones.items(), colours, strict=True)):
        amplitude = backbone["response_amplitude"].to_numpy() * MM
        dissipation = backbone["friction_dissipation"].to_numpy()
        least = _DRAWN * (dissipation / amplitude**2).max(initial=0)
        style = {"color": colour, "linewidth": 1.3}
        drawn = _above(least, amplitude, dissipation)
        lost.plot(amplitude, drawn, label=JointName(joint).label, **style)
        resonance.plot(amplitude, backbone["natural_frequency"], **style)
        if np.isfinite(fits.loc[joint, "power"]):
            _draw_power_law(lost, fits.loc[joint], colour, row)
        if joint in peaks:
            amplitude, style = peaks[joint].amplitude * MM, {"color": colour, "zorder": 4}
            drawn = _above(least, amplitude, peaks[joint].dissipation)
            lost.plot(amplitude, drawn, **style, **_PEAK_MARK)
            resonance.plot(amplitude, peaks[joint].frequency, **style, **_PEAK_MARK)
    if peaks:
        lost.plot([], [], color="0.4", label="peak of a response", **_PEAK_MARK)
    for axes in (lost, resonance):
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.grid(True)
    resonance.yaxis.set_major_locator(MaxNLocator(6))
    resonance.yaxis.set_major_formatter("{x:g}")
    resonance.yaxis.set_minor_formatter(NullFormatter())
    lost.set_ylabel("friction dissipation in a period (J)")
    resonance.set_ylabel("natural frequency (Hz)")
    resonance.set_xlabel("amplitude at the output point (mm)")
    lost.legend(loc="upper left")
    return figure


def _above(
    least: float, amplitude: NDArray[np.float64], dissipation: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The dissipation where, over the squared amplitude, it is more than a least value."""
    return np.where(dissipation > least * amplitude**2, dissipation, np.nan)


def _draw_power_law(axes: Axes, fit: pd.Series, colour: NDArray[np.float64], row: int) -> None:
    """The line of a fit with its power in a row of its own; with the first, that of spheres."""
    ends = fit[["from_amplitude_mm", "to_amplitude_mm"]].to_numpy(dtype=float)
    ratio = ends / ends[1]
    line = fit["dissipation_at_end_J"] * ratio ** fit["power"]
    label = f"microslip: power {fit['power']:.2f}"
    axes.plot(ends, line, color=colour, label=label, **_FIT_LINE)
    middle = np.sqrt(ends.prod()), np.sqrt(line.prod())
    axes.annotate(
        f"slope {fit['power']:.2f}",
        middle,
        xytext=(14, -16 - 12 * row),
        textcoords="offset points",
        color=colour,
    )
    if row == 0:
        spheres = fit["dissipation_at_end_J"] * ratio**_SPHERES
        style: dict[str, Any] = {"color": "0.4", "linewidth": 1.0, "linestyle": "--", "zorder": 1}
        axes.plot(ends, spheres, label="power 3, smooth spheres (Mindlin)", **style)
