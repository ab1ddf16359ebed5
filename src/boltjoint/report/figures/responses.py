"""Figures of frequency responses, backbones and the motion of sensors."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from boltjoint.names import JointName
from boltjoint.report.figures.curves import ResponseCurve, peaks_on_backbone, response_curves
from boltjoint.report.figures.style import (
    BREAK_MARK,
    MM,
    MODEL_LINE,
    REFERENCE_LINE,
    add_legends,
    figure_style,
    label_decades,
    level_colours,
    method_label,
)
from boltjoint.structure.extent import LINEAR

#: response over the excitation level, by the unit of the level
_RATIOS = {
    "N": "response / force (mm/N)",
    "m/s2": "response / acceleration of the supports (mm per m/s²)",
}
_PEAK_MARK = {"marker": "o", "mec": "white", "mew": 0.6, "linestyle": "none"}
_CONVERGED_MARK = {"marker": "D", "mfc": "white", "mew": 1.0, "linestyle": "none"}
_ERROR_BAR_LINE = {"linewidth": 0.8, "alpha": 0.8}
_UNSTABLE_LINE = {"linestyle": (0, (2.5, 1.5)), "marker": "none", "dash_capstyle": "butt"}
#: where stability is that of one harmonic
_ONE_HARMONIC = {"linestyle": (0, (1.0, 1.5))}
#: where the largest displacement is a tenth of the length
_LIMIT_LINE = {"linestyle": (0, (5, 2)), "linewidth": 0.9, "marker": "none"}
_LIMIT = f"linear model ends ({LINEAR:.0%} of the length)".replace("%", " %")
#: amplitude over that limit at which axes end
_BEYOND = 3
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
    tell above which response the linear model of the structure does not hold.

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
    drawn, marks = [], {"peak": _PEAK_MARK}
    for name, (dataset, style) in layers.items():
        size = 0.6 if style is REFERENCE_LINE and not is_reference else 1.0
        curves = response_curves(dataset)
        for index, (curve, colour) in enumerate(
            zip(curves, level_colours(forces.size), strict=True)
        ):
            x, y = curve.frequency, curve.amplitude
            label = f"{name}, {forces[index]:g} {unit}"
            axes.semilogy(
                x, np.where(curve.unstable > 0, np.nan, y), color=colour, label=label, **style
            )
            for harmonics in np.unique(curve.unstable[curve.unstable > 0]):
                part = np.where(_with_neighbours(curve.unstable == harmonics), y, np.nan)
                dashes = _UNSTABLE_LINE if harmonics > 1 else _UNSTABLE_LINE | _ONE_HARMONIC
                axes.plot(x, part, color=colour, **style, **dashes)
                of = f"{harmonics} harmonics" if harmonics > 1 else "one harmonic"
                marks[f"unstable ({of})"] = {**REFERENCE_LINE, **dashes}
            if curve.peak is not None:
                at = [curve.peak]
                axes.plot(x[at], y[at], color=colour, markersize=7 * size, zorder=4, **_PEAK_MARK)
            if curve.peak is not None and curve.converged is not None and dataset is response:
                to = zip((x[curve.peak], y[curve.peak]), curve.converged, strict=True)
                axes.plot(*to, color=colour, zorder=3, **_ERROR_BAR_LINE)
                at = [[value] for value in curve.converged]
                axes.plot(*at, color=colour, markersize=5, zorder=4, **_CONVERGED_MARK)
                marks["peak with all harmonics"] = _CONVERGED_MARK
            beyond = x[y > curve.linear_limit]
            if beyond.size and dataset is response:
                ends = [beyond.min(), beyond.max()]
                axes.plot(ends, [curve.linear_limit] * 2, color=colour, **_LIMIT_LINE)
                marks[_LIMIT] = _LIMIT_LINE
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
        Amplitude [mm] beyond which the linear model of the structure does not hold: the axes end at
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
                axes.axvline(limit, color="0.4", label=_LIMIT, **_LIMIT_LINE)
                axes.set_xlim(low, min(high, _BEYOND * limit))
    panels[0].legend()
    return figure


def _isolated_branches(backbone: xr.Dataset) -> Iterator[str]:
    """Each range of excitation with an isolated branch, in words."""
    unit = backbone["isolated_from"].attrs["units"]
    for low, high in zip(backbone["isolated_from"], backbone["isolated_to"], strict=True):
        yield f"isolated branch from {float(low):.4g} to {float(high):.4g} {unit}"


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
