"""Figures of sweeps: bands of responses, peaks over the keys, and Sobol indices."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from boltjoint.report.figures.style import (
    MM,
    REGION_COLOURS,
    figure_style,
    label_decades,
    level_colours,
)
from boltjoint.study.designs import varied

Array = NDArray[np.float64]

#: shares of the designs between which a band lies, from the widest
_BANDS = ((0.05, 0.95), (0.25, 0.75))
#: designs that are drawn one by one: more hide each other
_DOTS = 500
#: designs whose dots are larger
_FEW = 200
_WIDTH = 0.38


@figure_style
def plot_bands(sweep: xr.Dataset) -> Figure:
    """Median response of all designs by force, and the bands in which most of them lie.

    Parameters
    ----------
    sweep
        ``sweep.nc`` with responses.
    """
    figure = Figure(figsize=(8, 4.8), layout="constrained")
    axes = figure.subplots()
    frequency = sweep["frequency"].to_numpy()
    levels = list(_levels(sweep, "response_amplitude"))
    for (level, values), colour in zip(levels, level_colours(len(levels)), strict=True):
        known = values[np.isfinite(values).any(axis=1)] * MM
        if not known.size:
            continue
        for number, (low, high) in enumerate(_BANDS):
            ends = np.nanquantile(known, [low, high], axis=0)
            style = {"color": colour, "alpha": 0.2 + 0.2 * number, "linewidth": 0}
            axes.fill_between(frequency, *ends, **style)
        axes.plot(frequency, np.nanmedian(known, axis=0), color=colour, label=level)
    axes.set_yscale("log")
    label_decades(axes)
    axes.set(xlabel="frequency (Hz)", ylabel="response amplitude (mm)")
    axes.grid(True)
    handles, _ = axes.get_legend_handles_labels()
    handles += [
        Patch(color="0.3", alpha=0.2 + 0.2 * number, label=f"{high - low:.0%} of the designs")
        for number, (low, high) in enumerate(_BANDS)
    ]
    axes.legend(handles=[*handles, Line2D([], [], color="0.3", label="median")])
    return figure


@figure_style
def plot_peaks(sweep: xr.Dataset) -> Figure:
    """Frequency and amplitude of the peaks over each key that varies, a dot for each design.

    Parameters
    ----------
    sweep
        ``sweep.nc``; of many designs some are drawn.
    """
    keys = _keys(sweep)
    figure = Figure(figsize=(max(8, 2.4 * len(keys)), 5.6), layout="constrained")
    panels = figure.subplots(2, len(keys), sharex="col", sharey="row", squeeze=False)
    for row, (name, factor, label) in enumerate(
        (("peak_frequency", 1.0, "peak frequency (Hz)"), ("peak_amplitude", MM, "peak (mm)"))
    ):
        levels = list(_levels(sweep, name))
        for column, each in enumerate(keys.values()):
            axes = panels[row, column]
            for (level, values), colour in zip(levels, level_colours(len(levels)), strict=True):
                drawn = np.linspace(0, values.size - 1, min(values.size, _DOTS)).astype(int)
                size = 2.2 if drawn.size > _FEW else 4
                style = {"markersize": size, "alpha": 0.6, "color": colour, "markeredgewidth": 0}
                x, y = each.to_numpy().ravel()[drawn], factor * values[drawn]
                axes.plot(x, y, "o", label=level, **style)
            axes.grid(True)
        panels[row, 0].set_ylabel(label)
    for axes in panels[1]:
        axes.set_yscale("log")
    label_decades(panels[1, 0])
    for column, (name, each) in enumerate(keys.items()):
        panels[1, column].set_xlabel(_with_unit(name, each.attrs["units"]))
        if each.size and each.min() > 0 and each.max() > 5 * each.min():
            panels[1, column].set_xscale("log")
            label_decades(panels[1, column], "x")
        else:
            panels[1, column].xaxis.set_major_locator(MaxNLocator(4))
    handles, labels = panels[0, 0].get_legend_handles_labels()
    if labels and labels[0]:
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


@figure_style
def plot_sensitivity(table: pd.DataFrame) -> Figure:
    """Sobol indices of the peaks: a broad pale bar is the total, a narrow one the first order.

    Parameters
    ----------
    table
        As ``tabulate_sensitivity`` returns it.
    """
    keys = list(table["key"].unique())
    levels = list(table["force_N"].unique()) if "force_N" in table else [None]
    names = {"peak_frequency_Hz": "peak frequency", "peak_mm": "peak amplitude"}
    figure = Figure(figsize=(8, 5.6), layout="constrained")
    panels = figure.subplots(len(names), sharex=True, sharey=True)
    for axes, (observed, title) in zip(panels, names.items(), strict=True):
        of_peak = table[table["observed"] == observed]
        for number, (level, colour) in enumerate(
            zip(levels, level_colours(len(levels)), strict=True)
        ):
            rows = of_peak if level is None else of_peak[of_peak["force_N"] == level]
            colour = REGION_COLOURS[0] if level is None else colour
            width = 2 * _WIDTH / len(levels)
            at = np.arange(len(keys)) - _WIDTH + (number + 0.5) * width
            for order, share, alpha in (("total", 0.9, 0.35), ("first_order", 0.45, 0.9)):
                value = rows[order].to_numpy()
                ends = [value - rows[f"{order}_low"], rows[f"{order}_high"] - value]
                label = None if level is None or order == "total" else f"{level:g} N"
                axes.bar(at, value, share * width, color=colour, alpha=alpha, label=label)
                aside = (0.5 - share) * 0.3 * width
                style = {"color": "0.25", "linewidth": 0.9, "linestyle": "none", "capsize": 2}
                axes.errorbar(at + aside, value, np.clip(ends, 0, None), **style)
        axes.set_title(title)
        axes.set_ylabel("share of the variance")
        axes.grid(True, axis="y")
    panels[-1].set_xticks(range(len(keys)), [key.replace("_", " ") for key in keys])
    if levels != [None]:
        panels[0].legend()
    return figure


def _levels(sweep: xr.Dataset, name: str) -> Iterator[tuple[str | None, Array]]:
    """Levels by their words, and values of all designs at each, (designs, ...)."""
    values = sweep[name]
    last = [dim for dim in values.dims if dim == "frequency"]
    if "force" not in values.dims:
        yield None, _by_design(values, last)
        return
    unit = sweep["force_level"].attrs["units"].replace("m/s2", "m/s²")
    for number, level in enumerate(sweep["force_level"].to_numpy()):
        yield f"{level:g} {unit}", _by_design(values.isel(force=number), last)


def _by_design(values: xr.DataArray, last: list[str]) -> Array:
    found = values.to_numpy()
    return found.reshape(-1, found.shape[-1]) if last else found.ravel()


def _keys(sweep: xr.Dataset) -> dict[str, xr.DataArray]:
    """The quantities that vary, by design; none that has one value only."""
    found = {name: sweep[name].broadcast_like(sweep["reason"]) for name in varied(sweep)}
    return {name: each for name, each in found.items() if np.ptp(each.to_numpy()) > 0}


def _with_unit(name: str, unit: str) -> str:
    words = name.replace("_", " ")
    return words if unit == "1" else f"{words} ({unit})"
