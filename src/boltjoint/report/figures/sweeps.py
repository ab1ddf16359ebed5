"""Figures of sweeps: bands of responses, peaks over the keys, their extremes, Sobol indices."""

from collections.abc import Iterator
from textwrap import fill

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from boltjoint.number_format import number
from boltjoint.report.figures.style import (
    MM,
    REGION_COLOURS,
    figure_style,
    label_decades,
    level_colours,
)
from boltjoint.study.errors_of_sweep import peak_variable
from boltjoint.study.tables.sweeps import (
    backbone_quantiles,
    response_quantiles,
    values_of_keys,
)

Array = NDArray[np.float64]

#: shares of the designs between which a band lies, from the widest
_BANDS = ((0.05, 0.95), (0.25, 0.75))
#: designs that are drawn one by one: more hide each other
_DOTS = 500
#: designs whose backbones are drawn one by one
_LINES = 24
#: designs whose dots are larger
_FEW = 200
_WIDTH = 0.38
#: letters beside each other below an axis, and most names there that are not turned
_LETTERS, _MOST_LEVEL = 84, 8
#: ends of a key, and how opaque their bars are
_ENDS = {"low": 0.4, "high": 0.9}


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
    shares = [share for band in _BANDS for share in band]
    quantiles = response_quantiles(sweep, [0.5, *shares]) * MM
    levels = _level_words(sweep)
    for level, (median, *ends), colour in zip(
        levels, quantiles, level_colours(len(levels)), strict=True
    ):
        if np.isnan(median).all():
            continue
        for place in range(len(_BANDS)):
            style = {"color": colour, "alpha": 0.2 + 0.2 * place, "linewidth": 0}
            axes.fill_between(frequency, *ends[2 * place : 2 * place + 2], **style)
        axes.plot(frequency, median, color=colour, label=level)
    axes.set_yscale("log")
    label_decades(axes)
    axes.set(xlabel="frequency (Hz)", ylabel="response amplitude (mm)")
    axes.grid(True)
    handles, _ = axes.get_legend_handles_labels()
    handles += _band_patches("0.3")
    axes.legend(handles=[*handles, Line2D([], [], color="0.3", label="median")])
    return figure


@figure_style
def plot_backbones(sweep: xr.Dataset) -> Figure:
    """Natural frequency and damping ratio over amplitude: of each design, or bands of many.

    Parameters
    ----------
    sweep
        ``sweep.nc`` with backbones.
    """
    names = {"natural_frequency": "natural frequency (Hz)", "damping_ratio": "damping ratio"}
    amplitude = sweep["amplitude"].to_numpy() * MM
    rows = {
        name: sweep[name].transpose(..., "amplitude").to_numpy().reshape(-1, amplitude.size)
        for name in names
    }
    solved = np.flatnonzero(np.isfinite(rows["damping_ratio"]).any(axis=1))
    figure = Figure(figsize=(9.5, 6.4), layout="constrained")
    panels = figure.subplots(len(names), sharex=True)
    for axes, (name, label) in zip(panels, names.items(), strict=True):
        if len(solved) <= _LINES:
            lines = rows[name][solved], level_colours(len(solved)), _design_words(sweep, solved)
            for line, colour, words in zip(*lines, strict=True):
                axes.plot(amplitude, line, color=colour, label=words)
        else:
            shares = [share for band in _BANDS for share in band]
            median, *ends = backbone_quantiles(sweep, name, [0.5, *shares])
            for place in range(len(_BANDS)):
                style = {"color": REGION_COLOURS[0], "alpha": 0.2 + 0.2 * place, "linewidth": 0}
                axes.fill_between(amplitude, *ends[2 * place : 2 * place + 2], **style)
            axes.plot(amplitude, median, color=REGION_COLOURS[0], label="median")
        axes.set(ylabel=label, xscale="log")
        axes.grid(True)
    panels[1].set_yscale("log")
    label_decades(panels[1])
    panels[1].set_xlabel("amplitude of the output point (mm)")
    label_decades(panels[1], "x")
    handles, _ = panels[0].get_legend_handles_labels()
    if len(solved) > _LINES:
        handles += _band_patches(REGION_COLOURS[0])
    figure.legend(handles=handles, loc="outside right upper", fontsize="small")
    return figure


@figure_style
def plot_peaks(sweep: xr.Dataset) -> Figure:
    """Frequency and amplitude of the peaks over each key that varies, a dot for each design.

    Parameters
    ----------
    sweep
        ``sweep.nc``; of many designs some are drawn.
    """
    keys = values_of_keys(sweep)
    figure = Figure(figsize=(max(8, 2.4 * len(keys)), 5.6), layout="constrained")
    panels = figure.subplots(2, len(keys), sharex="col", sharey="row", squeeze=False)
    for row, (what, factor, label) in enumerate(
        (("frequency", 1.0, "peak frequency (Hz)"), ("amplitude", MM, "peak (mm)"))
    ):
        levels = list(_levels(sweep, peak_variable(sweep, what)))
        for column, key in enumerate(keys.values()):
            axes = panels[row, column]
            for (level, values), colour in zip(levels, level_colours(len(levels)), strict=True):
                drawn = np.linspace(0, values.size - 1, min(values.size, _DOTS)).astype(int)
                size = 2.2 if drawn.size > _FEW else 4
                style = {"markersize": size, "alpha": 0.6, "color": colour, "markeredgewidth": 0}
                x, y = key.to_numpy().ravel()[drawn], factor * values[drawn]
                axes.plot(x, y, "o", label=level, **style)
            axes.grid(True)
        panels[row, 0].set_ylabel(label)
    for axes in panels[1]:
        axes.set_yscale("log")
    label_decades(panels[1, 0])
    for column, (name, key) in enumerate(keys.items()):
        panels[1, column].set_xlabel(_with_unit(name, key.attrs["units"]))
        if key.size and key.min() > 0 and key.max() > 5 * key.min():
            panels[1, column].set_xscale("log")
            label_decades(panels[1, column], "x")
        else:
            panels[1, column].xaxis.set_major_locator(MaxNLocator(4))
    handles, labels = panels[0, 0].get_legend_handles_labels()
    if labels and labels[0]:
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


@figure_style
def plot_tornado(table: pd.DataFrame) -> Figure:
    """Tornado: how far the mean peak moves towards the low (pale) and the high end of each key.

    The key that moves a peak most is uppermost; a line on a bar is an interval of 95 %.

    Parameters
    ----------
    table
        As ``tabulate_extremes`` returns it.
    """
    levels = list(table["force_N"].unique()) if "force_N" in table else [None]
    changes = {
        "peak_frequency_Hz": ("change of the mean peak frequency (Hz)", lambda mean: 1.0),
        "peak_mm": ("change of the mean peak amplitude (%)", lambda mean: mean / 100),
    }
    count = table["key"].nunique()
    height = 1.5 + 0.45 * max(count, 1) * max(1, len(levels) / 2)
    figure = Figure(figsize=(9.5, height), layout="constrained")
    panels = figure.subplots(1, len(changes))
    for axes, (observed, (label, unit)) in zip(panels, changes.items(), strict=True):
        of_peak = table[table["observed"] == observed] if count else table
        moves = {
            end: (of_peak[f"{end}_mean"] - of_peak["mean"]) / unit(of_peak["mean"])
            for end in (_ENDS if count else ())
        }
        largest = pd.DataFrame(moves).abs().max(axis=1).fillna(0).groupby(of_peak["key"]).max()
        keys = list(largest.sort_values(kind="stable").index)
        for place, (level, colour) in enumerate(
            zip(levels, level_colours(len(levels)), strict=True)
        ):
            colour = REGION_COLOURS[0] if level is None else colour
            rows = of_peak if level is None else of_peak[of_peak["force_N"] == level]
            width = 2 * _WIDTH / len(levels)
            at = rows["key"].map(keys.index) + _WIDTH - (place + 0.5) * width
            for end, alpha in _ENDS.items() if count else ():
                move = moves[end][rows.index]
                label_of_bar = None if level is None or end == "low" else f"{level:g} N"
                style = {"color": colour, "alpha": alpha, "label": label_of_bar}
                axes.barh(at, move, 0.9 * width, **style)
                line = {"color": "0.25", "linewidth": 0.9, "linestyle": "none", "capsize": 2}
                error = rows[f"{end}_half_width"] / unit(rows["mean"])
                axes.errorbar(move, at, xerr=error.fillna(0), **line)
        axes.axvline(0, color="0.25", linewidth=0.7)
        bounds = of_peak.drop_duplicates("key").set_index("key") if count else of_peak
        axes.set_yticks(range(len(keys)), [_with_bounds(key, bounds.loc[key]) for key in keys])
        axes.tick_params("y", length=0)
        axes.set_xlabel(label)
        axes.grid(True, axis="x")
    if levels != [None] and count:
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(levels))
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
        for place, (level, colour) in enumerate(
            zip(levels, level_colours(len(levels)), strict=True)
        ):
            rows = of_peak if level is None else of_peak[of_peak["force_N"] == level]
            colour = REGION_COLOURS[0] if level is None else colour
            width = 2 * _WIDTH / len(levels)
            at = np.arange(len(keys)) - _WIDTH + (place + 0.5) * width
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
    words, angle = [key.replace("_", " ") for key in keys], 90
    if len(keys) <= _MOST_LEVEL:
        width, angle = _LETTERS // len(keys), 0
        words = [fill(label, width, break_long_words=False) for label in words]
    panels[-1].set_xticks(range(len(keys)), words, rotation=angle)
    if levels != [None]:
        panels[0].legend()
    return figure


def _band_patches(colour: str) -> list[Patch]:
    return [
        Patch(color=colour, alpha=0.2 + 0.2 * place, label=f"{high - low:.0%} of the designs")
        for place, (low, high) in enumerate(_BANDS)
    ]


def _design_words(sweep: xr.Dataset, rows: NDArray[np.intp]) -> list[str]:
    """The values of designs, of as many keys as tell them apart."""
    keys = values_of_keys(sweep)
    columns = [values.to_numpy()[rows] for values in keys.values()]
    count = next(
        (n for n in range(1, len(keys)) if len(set(zip(*columns[:n], strict=True))) == len(rows)),
        len(keys),
    )
    told = []
    for place in range(len(rows)):
        words = []
        for (name, values), column in zip(list(keys.items())[:count], columns, strict=False):
            unit = values.attrs["units"]
            number_of_key = f"{column[place]:.4g}{'' if unit == '1' else ' ' + unit}"
            words.append(f"{name.replace('_', ' ')} = {number_of_key}")
        told.append(", ".join(words))
    return told


def _level_words(sweep: xr.Dataset) -> list[str | None]:
    """Levels by their words; None for that of a sweep over levels."""
    if "force" not in sweep.dims:
        return [None]
    unit = sweep["force_level"].attrs["units"].replace("m/s2", "m/s²")
    return [f"{level:g} {unit}" for level in sweep["force_level"].to_numpy()]


def _levels(sweep: xr.Dataset, name: str) -> Iterator[tuple[str | None, Array]]:
    """Levels by their words, and values of all designs at each."""
    values = sweep[name]
    for place, words in enumerate(_level_words(sweep)):
        at_level = values if words is None else values.isel(force=place)
        yield words, at_level.to_numpy().ravel()


def _with_unit(name: str, unit: str) -> str:
    words = name.replace("_", " ")
    return words if unit == "1" else f"{words} ({unit})"


def _with_bounds(key: str, row: pd.Series) -> str:
    """A key with the values that bound its low and its high end."""
    unit = "" if row["unit"] == "1" else f" {row['unit']}"
    low, high = (number(row[f"{end}_bound"], 3) for end in _ENDS)
    return f"{key.replace('_', ' ')}\n≤ {low}, ≥ {high}{unit}"
