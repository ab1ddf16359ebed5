"""Figures of a calibration: measured curves beside those of the fitted joint, and predictions."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from boltjoint.report.figures.style import REGION_COLOURS, figure_style, label_decades

#: standard deviations of 95 %
_REACH = 1.96
#: variables of frequency and damping ratio, their labels and factors
_ROWS = (
    ("frequency", "frequency_deviation", "natural frequency (Hz)", 1.0),
    ("damping_ratio", "damping_deviation", "damping ratio (%)", 100.0),
)
#: points as measured
_MEASURED: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 3}
_WORDS = {"modal": "modal amplitude"}


@figure_style
def plot_calibration(calibration: xr.Dataset) -> Figure:
    """Frequency and damping ratio of each curve over its amplitude, and their residuals.

    Parameters
    ----------
    calibration
        ``calibration.nc``.
    """
    curves = [str(curve) for curve in calibration["curve"].to_numpy()]
    figure = Figure(figsize=(8, 6.4), layout="constrained")
    panels = figure.subplots(
        4, len(curves), sharex="col", squeeze=False, gridspec_kw={"height_ratios": [3, 1, 3, 1]}
    )
    for place, name in enumerate(curves):
        column = panels[:, place]
        column[0].set_title(name, loc="left")
        for row, names in enumerate(_ROWS):
            _plot_curve(calibration, place, column[2 * row], column[2 * row + 1], *names)
        _label_amplitude(column[-1], calibration, place)
    panels[0, 0].legend(loc="best")
    return figure


@figure_style
def plot_prediction(prediction: xr.Dataset) -> Figure:
    """Frequency and damping ratio of curves that were held aside, with their bands.

    Parameters
    ----------
    prediction
        ``prediction.nc``.
    """
    curves = [str(curve) for curve in prediction["curve"].to_numpy()]
    figure = Figure(figsize=(8, 5), layout="constrained")
    panels = figure.subplots(2, len(curves), sharex="col", squeeze=False)
    for place, curve in enumerate(curves):
        panels[0, place].set_title(curve, loc="left")
        points = prediction["curve_of_point"].to_numpy() == place
        amplitude = prediction["amplitude"].to_numpy()[points]
        for axes, (name, deviation, label, factor) in zip(panels[:, place], _ROWS, strict=True):
            measured, scatter, model, low, high = (
                factor * prediction[variable].to_numpy()[points]
                for variable in (
                    *(name, deviation, f"model_{name}"),
                    *(f"{name}_low", f"{name}_high"),
                )
            )
            colour = REGION_COLOURS[place % len(REGION_COLOURS)]
            _plot_measured(axes, amplitude, measured, scatter)
            axes.fill_between(amplitude, low, high, color=colour, alpha=0.3, linewidth=0)
            label_of_model = "predicted, with the 95 % band of a measurement"
            axes.plot(amplitude, model, color=colour, label=label_of_model, zorder=3)
            axes.set_ylabel(label)
            axes.grid(True)
        _label_amplitude(panels[-1, place], prediction, place)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure


@figure_style
def plot_fitted_responses(calibration: xr.Dataset) -> Figure:
    """Response per excitation over frequency, measured and of the fitted joint.

    Parameters
    ----------
    calibration
        ``calibration.nc`` with responses.
    """
    kinds = [
        (str(quantity), str(unit))
        for quantity, unit in zip(
            calibration["response_amplitude_quantity"].to_numpy(),
            calibration["response_amplitude_unit"].to_numpy(),
            strict=True,
        )
    ]
    columns = list(dict.fromkeys(kinds))
    has_phase = bool(calibration["response_phase"].notnull().any())
    ratios = [3, 2, 1] if has_phase else [3, 1]
    figure = Figure(figsize=(8, 2.2 + 1.6 * len(ratios)), layout="constrained")
    panels = figure.subplots(
        len(ratios), len(columns), sharex="col", squeeze=False, height_ratios=ratios
    )
    level = calibration["response_excitation"].attrs["units"]
    for place, kind in enumerate(kinds):
        _plot_response(calibration, place, panels[:, columns.index(kind)])
    for column, (quantity, unit) in zip(panels.T, columns, strict=True):
        curve, *_, residual = column
        curve.plot([], [], color="0.45", alpha=0.5, label="measured", **_MEASURED)
        curve.set_ylabel(f"{quantity} per excitation\n({unit or 'unit not told'}/{level})")
        curve.set_yscale("log")
        curve.legend(loc="best")
        if has_phase:
            column[1].set_ylabel("phase (°)")
        residual.axhline(0.0, color="0.6", linewidth=0.8)
        residual.axhspan(-_REACH, _REACH, color="0.93", zorder=0)
        residual.set_ylabel("residual")
        residual.set_xlabel("frequency (Hz)")
        for axes in column:
            axes.grid(True)
    return figure


def _plot_response(calibration: xr.Dataset, place: int, column: NDArray[np.object_]) -> None:
    """A response as measured and of the fitted joint, its phase if it is compared, residuals."""
    points = calibration["response_of_point"].to_numpy() == place
    at, amplitude, excitation, model, deviation, phase, of_model = (
        calibration[name].to_numpy()[points]
        for name in (
            *("response_frequency", "response_amplitude", "response_excitation"),
            *("model_excitation", "response_excitation_deviation"),
            *("response_phase", "model_phase"),
        )
    )
    name = str(calibration["response"].to_numpy()[place])
    colour = REGION_COLOURS[place % len(REGION_COLOURS)]
    curve, *further, residual = column
    curve.plot(at, amplitude / excitation, color=colour, alpha=0.5, **_MEASURED)
    curve.plot(at, amplitude / model, color=colour, linewidth=1.3, label=name)
    for axes in further:
        axes.plot(at, np.rad2deg(phase), color=colour, alpha=0.5, **_MEASURED)
        axes.plot(at, np.rad2deg(of_model), color=colour, linewidth=1.3)
    off = np.log(model / excitation) * excitation / deviation
    residual.plot(at, off, color=colour, **_MEASURED)


def _label_amplitude(axes: Axes, dataset: xr.Dataset, place: int) -> None:
    """The logarithmic axis of the amplitude of a curve."""
    quantity = str(dataset["amplitude_quantity"].to_numpy()[place])
    unit = str(dataset["amplitude_unit"].to_numpy()[place])
    axes.set_xlabel(f"{_WORDS.get(quantity, quantity)} ({unit or 'unit not told'})")
    axes.set_xscale("log")
    label_decades(axes, "x")


def _plot_measured(
    axes: Axes,
    amplitude: NDArray[np.float64],
    measured: NDArray[np.float64],
    scatter: NDArray[np.float64],
) -> None:
    """Measured points with their stated scatter."""
    axes.errorbar(
        amplitude,
        measured,
        _REACH * scatter,
        fmt="o",
        markersize=3,
        linewidth=0.8,
        color="0.45",
        label="measured, 95 %",
        zorder=2,
    )


def _plot_curve(
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
        calibration[variable].to_numpy()[points] for variable in (name, deviation, f"model_{name}")
    )
    _plot_measured(curve, amplitude, factor * measured, factor * scatter)
    x, line, band = (
        calibration[variable].to_numpy()[grid]
        for variable in ("grid_amplitude", f"grid_{name}", f"grid_{deviation}")
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
