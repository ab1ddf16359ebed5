"""Figure of a calibration: measured points, the fitted backbone and its band, and residuals."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from boltjoint.report.figures.style import REGION_COLOURS, figure_style, label_decades

#: standard deviations of 95 %
_REACH = 1.96
#: variables of frequency and damping ratio, their labels and factors
_ROWS = (
    ("frequency", "frequency_deviation", "natural frequency (Hz)", 1.0),
    ("damping_ratio", "damping_deviation", "damping ratio (%)", 100.0),
)
_WORDS = {"modal": "modal amplitude"}


@figure_style
def plot_calibration(calibration: xr.Dataset) -> Figure:
    """Frequency and damping ratio of each curve over its amplitude, and their residuals.

    Parameters
    ----------
    calibration
        ``calibration.nc``.
    """
    curves = [str(each) for each in calibration["curve"].to_numpy()]
    figure = Figure(figsize=(8, 6.4), layout="constrained")
    panels = figure.subplots(
        4, len(curves), sharex="col", squeeze=False, gridspec_kw={"height_ratios": [3, 1, 3, 1]}
    )
    for place, name in enumerate(curves):
        column = panels[:, place]
        column[0].set_title(name, loc="left")
        for row, names in enumerate(_ROWS):
            _plot(calibration, place, column[2 * row], column[2 * row + 1], *names)
        quantity = str(calibration["amplitude_quantity"].to_numpy()[place])
        unit = str(calibration["amplitude_unit"].to_numpy()[place])
        column[-1].set_xlabel(f"{_WORDS.get(quantity, quantity)} ({unit or 'unit not told'})")
        column[-1].set_xscale("log")
        label_decades(column[-1], "x")
    panels[0, 0].legend(loc="best")
    return figure


def _plot(
    calibration: xr.Dataset,
    place: int,
    curve: Axes,
    residual: Axes,
    name: str,
    deviation: str,
    label: str,
    factor: float,
) -> None:
    """One quantity of a curve, and below it its residuals."""
    colour = REGION_COLOURS[place % len(REGION_COLOURS)]
    points = calibration["curve_of_point"].to_numpy() == place
    grid = calibration["curve_of_grid"].to_numpy() == place
    amplitude = calibration["amplitude"].to_numpy()[points]
    measured, scatter, model = (
        calibration[each].to_numpy()[points] for each in (name, deviation, f"model_{name}")
    )
    curve.errorbar(
        amplitude,
        factor * measured,
        _REACH * factor * scatter,
        fmt="o",
        markersize=3,
        linewidth=0.8,
        color="0.45",
        label="measured, 95 %",
        zorder=2,
    )
    x, line, band = (
        calibration[each].to_numpy()[grid]
        for each in ("grid_amplitude", f"grid_{name}", f"grid_{deviation}")
    )
    reach = _REACH * np.minimum(band, line)
    curve.fill_between(
        x, factor * (line - reach), factor * (line + reach), color=colour, alpha=0.3, linewidth=0
    )
    curve.plot(x, factor * line, color=colour, label="fitted, with its 95 % band", zorder=3)
    curve.set_ylabel(label)
    curve.grid(True)
    residual.axhline(0.0, color="0.6", linewidth=0.8)
    residual.axhspan(-_REACH, _REACH, color="0.93", zorder=0)
    residual.plot(amplitude, (model - measured) / scatter, "o", markersize=3, color=colour)
    residual.set_ylabel("residual")
