"""Figures of frequency responses, of the motion of sensors, and of computing times."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from boltjoint.harmonics import in_words
from boltjoint.names import Coordinates, JointName
from boltjoint.report.figures.curves import (
    LIMIT,
    LIMIT_LINE,
    ResponseCurve,
    response_curves,
)
from boltjoint.report.figures.style import (
    BREAK_MARK,
    COORDINATE_LINES,
    MM,
    MODEL_LINE,
    REFERENCE_LINE,
    REGION_COLOURS,
    add_legends,
    figure_style,
    label_decades,
    level_colours,
    method_label,
)

#: response over the excitation level, by the unit of the level
_RATIOS = {
    "N": "response / force (mm/N)",
    "m/s2": "response / acceleration of the supports (mm per m/s²)",
}
_PEAK_MARK: Mapping[str, Any] = {"marker": "o", "mec": "white", "mew": 0.6, "linestyle": "none"}
_CONVERGED_MARK: Mapping[str, Any] = {
    "marker": "D",
    "mfc": "white",
    "mew": 1.0,
    "linestyle": "none",
}
_ERROR_BAR_LINE: Mapping[str, Any] = {"linewidth": 0.8, "alpha": 0.8}
_UNSTABLE_LINE: dict[str, Any] = {
    "linestyle": (0, (2.5, 1.5)),
    "marker": "none",
    "dash_capstyle": "butt",
}
#: where stability is that of one harmonic
_ONE_HARMONIC = {"linestyle": (0, (1.0, 1.5))}
#: response over its peak down to which a curve is in the axes
_FLANK = 1 / 2
#: margin on both sides of that, over its width, and at least over the frequency
_MARGIN, _LEAST_MARGIN = 0.25, 0.02
#: response over the lowest peak down to which antiresonances are in the axes
_DEPTH = 1 / 30


@figure_style
def plot_response(
    response: xr.Dataset, joint: str, coordinates: str, reference: xr.Dataset | None = None
) -> Figure:
    """Response over frequency at all force levels, divided by the force.

    The axes span the frequencies at which some response is half its peak or more, and a margin.
    Dashed are solutions whose motion is unstable, dotted those where that is known of few harmonics
    only. Peaks with as many harmonics as converge are joined to those of the response. Long dashes
    tell above which response the model does not hold.

    Parameters
    ----------
    response
        As ``solve_response`` returns it.
    joint
        Name of the joint that was solved, such as ``regions=6/elements=7``.
    coordinates
        Name of the coordinates, such as ``linear`` or ``rdnm-1``.
    reference
        Response of the node-to-node joint in linear modes at the same forces, to compare with.

    Raises
    ------
    ValueError
        If the reference was solved at other forces.
    """
    forces = response["force_level"].to_numpy()
    if reference is not None and not np.array_equal(forces, reference["force_level"].to_numpy()):
        raise ValueError("response and reference were solved at different forces")
    is_reference = (joint, coordinates) == ("node-to-node", "linear")
    line = REFERENCE_LINE if is_reference else MODEL_LINE
    layers = {method_label(joint, coordinates): (response, line)}
    if reference is not None:
        layers = {method_label("node-to-node", "linear"): (reference, REFERENCE_LINE)} | layers
    unit = response["force_level"].attrs["units"]
    levels = [f"{force:g} {unit}" for force in forces]
    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.subplots()
    drawn: list[ResponseCurve] = []
    marks: dict[str, Mapping[str, Any]] = {"peak": _PEAK_MARK}
    for name, (dataset, style) in layers.items():
        size = 0.6 if style is REFERENCE_LINE and not is_reference else 1.0
        curves = response_curves(dataset)
        for index, (curve, colour) in enumerate(
            zip(curves, level_colours(forces.size), strict=True)
        ):
            x, y = curve.frequency, curve.amplitude
            label = f"{name}, {forces[index]:g} {unit}"
            drawing = {"color": colour, "label": label, **style}
            marks |= _draw_curve(axes, curve, drawing, size, with_marks=dataset is response)
            if curve.broken_off:
                axes.plot(x[-1:], y[-1:], color=colour, markersize=9 * size, zorder=5, **BREAK_MARK)
                marks["branch breaks off"] = BREAK_MARK
                levels[index] += f"\n{'reference ' if dataset is reference else ''}{curve.end}"
            if curve.fell_back:
                levels[index] += "\nreplaced by linear modes"
        drawn += curves
    _set_limits(axes, drawn)
    axes.set(xlabel="frequency (Hz)", ylabel=_RATIOS[unit])
    axes.grid(True)
    add_legends(axes, {name: style for name, (_, style) in layers.items()}, "force", levels, marks)
    return figure


def _draw_curve(
    axes: Axes, curve: ResponseCurve, line: Mapping[str, Any], size: float, *, with_marks: bool
) -> dict[str, Mapping[str, Any]]:
    """A curve with its peak, unstable parts and, if asked for, further marks; what these are."""
    x, y, colour = curve.frequency, curve.amplitude, line["color"]
    style = {name: value for name, value in line.items() if name not in ("color", "label")}
    marks: dict[str, Mapping[str, Any]] = {}
    axes.semilogy(x, np.where(curve.unstable > 0, np.nan, y), **line)
    for harmonics in np.unique(curve.unstable[curve.unstable > 0]):
        part = np.where(_with_neighbours(curve.unstable == harmonics), y, np.nan)
        dashes = _UNSTABLE_LINE if harmonics > 1 else _UNSTABLE_LINE | _ONE_HARMONIC
        axes.plot(x, part, color=colour, **style, **dashes)
        marks[f"unstable ({in_words([harmonics])})"] = {**REFERENCE_LINE, **dashes}
    if curve.peak is not None:
        at_peak = [curve.peak]
        axes.plot(x[at_peak], y[at_peak], color=colour, markersize=7 * size, zorder=4, **_PEAK_MARK)
    if with_marks and curve.peak is not None and curve.converged is not None:
        to = zip((x[curve.peak], y[curve.peak]), curve.converged, strict=True)
        axes.plot(*to, color=colour, zorder=3, **_ERROR_BAR_LINE)
        at = [[value] for value in curve.converged]
        axes.plot(*at, color=colour, markersize=5, zorder=4, **_CONVERGED_MARK)
        marks["peak with all harmonics"] = _CONVERGED_MARK
    beyond = x[y > curve.model_limit]
    if with_marks and beyond.size:
        ends = [beyond.min(), beyond.max()]
        axes.plot(ends, [curve.model_limit] * 2, color=colour, **LIMIT_LINE)
        marks[LIMIT] = LIMIT_LINE
    return marks


def _with_neighbours(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The mask extended by one place on each side."""
    return np.convolve(mask, [1, 1, 1], "same") > 0


def _set_limits(axes: Axes, curves: Sequence[ResponseCurve]) -> None:
    """Limit both axes to where some curve is near its peak, or breaks off."""
    curves = [curve for curve in curves if curve.frequency.size]
    if not curves:
        return
    near = np.concatenate(
        [c.frequency[c.amplitude >= _FLANK * c.amplitude.max()] for c in curves]
        + [np.array([c.converged[0]]) for c in curves if c.converged]
    )
    ends = [c.frequency[-1] for c in curves if c.broken_off]
    low, high = min([near.min(), *ends]), max([near.max(), *ends])
    margin = max(_MARGIN * (high - low), _LEAST_MARGIN * high)
    frequency = np.concatenate([c.frequency for c in curves])
    if frequency.min() < frequency.max():
        low, high = max(low - margin, frequency.min()), min(high + margin, frequency.max())
    else:
        low, high = low - margin, high + margin
    axes.set_xlim(low, high)
    in_view = np.concatenate(
        [c.amplitude[(c.frequency >= low) & (c.frequency <= high)] for c in curves]
        + [np.array([c.converged[1]]) for c in curves if c.converged]
    )
    lowest = max(in_view.min() / 1.3, _DEPTH * min(c.amplitude.max() for c in curves))
    axes.set_ylim(lowest, in_view.max() * 1.5)


@figure_style
def plot_sensors(response: xr.Dataset) -> Figure:
    """Amplitude of each sensor over frequency at all levels, divided by the level.

    Parameters
    ----------
    response
        ``response.nc``.
    """
    names, levels = response["sensor"].to_numpy(), response["force_level"].to_numpy()
    unit = response["force_level"].attrs["units"]
    figure = Figure(figsize=(8, 1 + 2.5 * names.size), layout="constrained")
    panels = figure.subplots(names.size, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, names, strict=True):
        amplitude = response["sensor_amplitude"].sel(sensor=name).to_numpy()
        for level, colour in zip(levels, level_colours(levels.size), strict=True):
            at = (response["excitation_force"] == level) & (response["converged"] == 1)
            x = response["frequency"].to_numpy()[at]
            axes.semilogy(x, MM * amplitude[at] / level, color=colour, **REFERENCE_LINE)
        axes.set(ylabel=f"{name}\n(mm per {unit})")
        axes.grid(True)
    panels[-1].set_xlabel("frequency (Hz)")
    labels = [f"{level:g} {unit}" for level in levels]
    add_legends(panels[0], {"node to node, linear modes": REFERENCE_LINE}, "level", labels, {})
    return figure


_TIME_LINE: Mapping[str, Any] = {"linewidth": 1.1, "markersize": 3.5}
_MARK_OF_SOURCE = {"linestyle": "none", "markersize": 7, "markerfacecolor": "none"}


@figure_style
def plot_times(
    times: pd.DataFrame, resonance: int = 1, source: tuple[str, str] | None = None
) -> Figure:
    """Solution times over force of every joint and coordinates, by kind of Jacobian.

    Below the times are their ratios to those of the node-to-node joint in linear modes. Ratios
    of a source are drawn beside those with finite differences.

    Parameters
    ----------
    times
        As ``tabulate_times`` returns it.
    resonance
        The resonance that the branches were solved around.
    source
        Name of another source of reductions of time, and its column.

    Raises
    ------
    ValueError
        If nothing was solved around that resonance.
    """
    times = times[times["resonance"] == resonance]
    if times.empty:
        raise ValueError(f"nothing was solved around resonance {resonance}")
    forces = np.unique(times["force_N"])
    # forces are spread evenly: their logarithms would leave most of the width to the lowest
    times = times.assign(place=np.searchsorted(forces, times["force_N"]))
    colours = dict(
        zip(times["joint"].unique(), ("0.15", *REGION_COLOURS) * len(times), strict=False)
    )
    styles = dict(zip(times["coordinates"].unique(), COORDINATE_LINES * len(times), strict=False))
    figure = Figure(figsize=(8, 6.4), layout="constrained")
    jacobians = {"analytic": "", "forward-difference": "_forward_difference"}
    jacobians = {
        name: ending for name, ending in jacobians.items() if times[f"cpu{ending}_s"].notna().any()
    }
    panels = figure.subplots(2, len(jacobians), sharex=True, sharey="row", squeeze=False)
    for (seconds, ratios), (jacobian, ending) in zip(panels.T, jacobians.items(), strict=True):
        for (joint, coordinates), rows in times.groupby(["joint", "coordinates"], sort=False):
            rows = rows.sort_values("force_N")
            place, cpu = rows["place"], rows[f"cpu{ending}_s"]
            ratio = 1 - rows[f"reduction{ending}_percent"] / 100
            colour, style = {"color": colours[joint]}, styles[coordinates]
            label = method_label(joint, coordinates)
            complete = rows[f"complete{ending}"].astype(bool)
            seconds.plot(place, cpu.where(complete), label=label, **colour, **style, **_TIME_LINE)
            if not complete.all():
                seconds.plot(place[~complete], cpu[~complete], **colour, **BREAK_MARK)
            ratios.plot(place, ratio, label=label, **colour, **style, **_TIME_LINE)
            if source is not None and jacobian == "forward-difference":
                name, column = source
                ratio, style = 1 - rows[column] / 100, {**style, **_MARK_OF_SOURCE}
                ratios.plot(place, ratio, label=f"{label}, {name}", **colour, **style)
        seconds.set_title(f"{jacobian} Jacobian")
        ratios.set_xticks(np.arange(forces.size), [f"{force:g}" for force in forces])
        ratios.set_xlabel("force (N)")
        for axes in (seconds, ratios):
            axes.set_yscale("log")
            label_decades(axes)
            axes.grid(True)
    panels[0, 0].set_ylabel("processor time (s)")
    panels[1, 0].set_ylabel("time over that of\nnode-to-node, linear modes")
    plain: dict[str, Any] = {"color": "0.4"}
    entries = {JointName(j).label: Line2D([], [], color=c, lw=3) for j, c in colours.items()}
    for coordinates, style in styles.items():
        entries[Coordinates(coordinates).short_label] = Line2D(
            [], [], **plain, **style, **_TIME_LINE
        )
    if source and "forward-difference" in jacobians and times[source[1]].notna().any():
        style = {**COORDINATE_LINES[0], **_MARK_OF_SOURCE}
        entries[source[0]] = Line2D([], [], **plain, **style)
    if any(
        (times[f"cpu{ending}_s"].notna() & ~times[f"complete{ending}"]).any()
        for ending in jacobians.values()
    ):
        entries["branch breaks off"] = Line2D([], [], **plain, **BREAK_MARK)
    figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=4)
    return figure
