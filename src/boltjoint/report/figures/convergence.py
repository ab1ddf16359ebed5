"""Figures of convergence: errors over samples, basis vectors, regions and models."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from boltjoint.names import Basis, JointName
from boltjoint.report.figures.point_labels import add_point_label, place_point_labels
from boltjoint.report.figures.style import (
    COORDINATE_LINES,
    REGION_COLOURS,
    figure_style,
    label_decades,
    level_colours,
    method_label,
)


@figure_style
def plot_sampling(table: pd.DataFrame) -> Figure:
    """Error of friction forces by AFT against the closed forms, over the number of samples.

    Parameters
    ----------
    table
        As ``tabulate_sampling`` returns it.
    """
    cases = list(table.groupby(["case", "law"], sort=False))
    columns = max(1, min(2, len(cases)))
    rows = max(1, -(-len(cases) // columns))
    figure = Figure(figsize=(5 * columns, 0.6 + 2.8 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels[0, 0].set(xscale="log", yscale="log")
    for axes, ((case, law), of_case) in zip(panels.flat, cases, strict=False):
        levels = list(of_case.groupby("force_N"))
        for (force, of_level), colour in zip(levels, level_colours(len(levels)), strict=True):
            style = {"color": colour, "linewidth": 1.1, "marker": "o", "markersize": 3.5}
            axes.loglog("samples", "error_relative", data=of_level, label=f"{force:g} N", **style)
        samples = np.unique(of_case["samples"])
        second_order = of_case["error_relative"].max() * (samples / samples[0]) ** -2.0
        style = {"color": "0.4", "linestyle": "--", "linewidth": 1.0, "zorder": 1}
        axes.plot(samples, second_order, label="second order", **style)
        axes.set_xticks(samples, samples)
        axes.minorticks_off()
        axes.set_title(f"{case}, {law} normal load")
        axes.legend(loc="upper left", bbox_to_anchor=(1, 1), fontsize=8, handlelength=1.5)
        axes.grid(True)
    for axes in panels.flat[max(1, len(cases)) :]:
        axes.set_axis_off()
    figure.supxlabel("time samples per period", fontsize=9)
    figure.supylabel("relative error of friction forces", fontsize=9)
    return figure


@figure_style
def plot_models(models: pd.DataFrame) -> Figure:
    """Largest errors of the peaks of every model, beside its cost.

    Parameters
    ----------
    models
        As ``tabulate_models`` returns it.
    """
    groups = list(models.groupby(["modes", "joint", "coordinates"], sort=False))
    groups.sort(key=lambda group: not Basis(group[0][0]).is_contact_adapted)
    figure = Figure(figsize=(8, 1.1 + 0.2 * len(groups)), layout="constrained")
    errors, costs = figure.subplots(1, 2, sharey=True)
    columns = {"frequency": REGION_COLOURS[0], "amplitude": REGION_COLOURS[1]}
    for row, (_, rows) in enumerate(groups):
        for what, colour in columns.items():
            error = rows[f"peak_{what}_error_percent"].abs().max()
            marker = "o" if rows["complete"].all() else "X"
            if error > 0:
                errors.plot(error, row, marker, color=colour, markersize=5)
        costs.plot(rows["cpu_s"].sum(), row, "o", color="0.3", markersize=5)
    words = [
        f"{basis}, {method_label(joint, coordinates)}" for (basis, joint, coordinates), _ in groups
    ]
    errors.set_yticks(range(len(groups)), words, fontsize=8)
    errors.set_ylim(len(groups) - 0.5, -0.5)
    errors.set_xlabel("largest error of a peak (%)")
    costs.set_xlabel("processor time of all forces (s)")
    for axes in (errors, costs):
        axes.set_xscale("log")
        # whole decades, so that at least two of them are labelled
        low, high = np.log10(axes.get_xlim())
        axes.set_xlim(10 ** np.floor(low), 10 ** np.ceil(high))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.tick_params(axis="y", length=0)
        axes.grid(True)
    entries = [
        Line2D([], [], color=colour, marker="o", linestyle="none", label=what)
        for what, colour in columns.items()
    ]
    broken: dict[str, Any] = {"color": "0.3", "marker": "X", "linestyle": "none"}
    if not models["complete"].all():
        entries.append(Line2D([], [], label="some branches broke off", **broken))
    figure.legend(handles=entries, loc="outside upper center", ncols=len(entries))
    return figure


@figure_style
def plot_patterns(table: pd.DataFrame) -> Figure:
    """Errors of bases over their size: the largest over all patterns of sticking pairs.

    Parameters
    ----------
    table
        As ``tabulate_patterns`` returns it.
    """
    springs = {"x": "springs along the bar", "xz": "springs along the bar and across the contact"}
    figure = Figure(figsize=(8, 3.6), layout="constrained")
    panels = figure.subplots(1, len(springs), sharex=True, sharey=True)
    largest = table.groupby(["springs", "basis", "vectors", "resonance"], sort=False)[
        "error_percent"
    ].max()
    for axes, (name, words) in zip(panels, springs.items(), strict=True):
        errors = largest[name].reset_index()
        _plot_over_vectors(axes, errors, "error_percent", "resonance", "resonance {}")
        axes.set_title(words)
    _add_legend_of_bases(panels)
    figure.supylabel("largest error of a resonance (%)", fontsize=9)
    return figure


@figure_style
def plot_bases(table: pd.DataFrame) -> Figure:
    """Errors of the peaks found in bases over their size, by force.

    Parameters
    ----------
    table
        As ``tabulate_basis_peaks`` returns it.
    """
    figure = Figure(figsize=(8, 3.8), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True)
    for axes, what in zip(panels, ("frequency", "amplitude"), strict=True):
        _plot_over_vectors(axes, table, f"peak_{what}_error_percent", "force_N", "{:g} N")
        axes.set_ylabel(f"error of the peak's {what} (%)")
    _add_legend_of_bases(panels)
    return figure


@figure_style
def plot_divisions(table: pd.DataFrame) -> Figure:
    """Largest errors of peaks over the number of regions, by division and motion.

    Parameters
    ----------
    table
        As ``tabulate_divisions`` returns it.
    """
    figure = Figure(figsize=(8, 4.4), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True)
    groups = list(table.groupby(["division", "motion"], sort=False))
    for ((division, motion), rows), colour in zip(groups, REGION_COLOURS, strict=False):
        largest = rows.drop(columns=["division", "motion"]).abs().groupby("regions").max()
        style = {"color": colour, "linewidth": 1.2, "markersize": 4}
        for axes, what in zip(panels, ("frequency", "amplitude"), strict=True):
            error = largest[f"peak_{what}_error_percent"]
            label = f"{division}, {motion}".replace("-", " ")
            axes.loglog(largest.index, error, marker="o", label=label, **style)
        style |= {"linestyle": ":", "marker": ".", "linewidth": 0.9}
        panels[0].loglog(largest.index, largest["region_error_percent"], zorder=1, **style)
    for axes, what in zip(panels, ("frequency", "amplitude"), strict=True):
        axes.set_xticks(table["regions"].unique(), table["regions"].unique())
        axes.minorticks_off()
        axes.set_xlabel("regions")
        axes.set_ylabel(f"largest error of a peak's {what} (%)")
        axes.grid(True)
    estimate = Line2D([], [], color="0.3", linestyle=":", marker=".", linewidth=0.9)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        [*handles, estimate],
        [*labels, "estimated without a response"],
        loc="outside lower center",
        ncols=3,
    )
    return figure


@figure_style
def plot_reductions(
    tables: Mapping[tuple[str, str], pd.DataFrame], tolerances: Mapping[str, float]
) -> Figure:
    """Largest errors of the peaks of reduced joints over the time of a response.

    Parameters
    ----------
    tables
        As ``tabulate_reductions`` returns them, by law and case.
    tolerances
        ``frequency_tolerance`` and ``amplitude_tolerance`` of weighted pairs.
    """
    laws = list(dict.fromkeys(law for law, _ in tables))
    figure = Figure(figsize=(8, 6.6), layout="constrained")
    panels = figure.subplots(2, len(laws), sharex=True, sharey="row", squeeze=False)
    colours: dict[str, str] = {}
    palette = (*REGION_COLOURS, "0.1", "0.6")
    for column, law in enumerate(laws):
        of_law = [table for (name, _), table in tables.items() if name == law]
        largest = _largest_of_joints(of_law)
        for kind, rows in largest.groupby("kind", sort=False):
            if len(rows) == 1:
                kind = f"{rows['number'].iloc[0]} {kind}"
                rows = rows.assign(number="")
            colour = colours.setdefault(kind, palette[len(colours) % len(palette)])
            for axes, what in zip(panels[:, column], ("frequency", "amplitude"), strict=True):
                _plot_errors_over_time(axes, rows, what, colour)
        for axes, what in zip(panels[:, column], ("frequency", "amplitude"), strict=True):
            style = {"color": "0.4", "linestyle": ":", "linewidth": 1.0, "zorder": 1}
            axes.axvline(largest["cpu_s_of_all"].iloc[0], **style)
            axes.axhline(100 * tolerances[f"{what}_tolerance"], **style)
            axes.grid(True)
            label_decades(axes)
            label_decades(axes, "x")
        panels[0, column].set_title(f"{law} normal load")
        panels[1, column].set_xlabel("mean processor time of a response (s)")
    for axes, what in zip(panels[:, 0], ("frequency", "amplitude"), strict=True):
        axes.set_ylabel(f"largest error of a peak's {what} (%)")
    entries = [
        Line2D([], [], color=colour, marker="o", markersize=4, linewidth=1.1, label=kind)
        for kind, colour in colours.items()
    ]
    figure.legend(handles=entries, loc="outside lower center", ncols=4)
    place_point_labels(figure)
    return figure


def _largest_of_joints(tables: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """By joint, the largest errors and the mean time of several cases."""
    parts = []
    for table in tables:
        by_joint = table.groupby("joint", sort=False)
        errors = table.set_index("joint").filter(like="_error_percent").abs()
        part = errors.groupby(level=0, sort=False).max()
        part["cpu_s"] = by_joint["cpu_s"].mean()
        has_errors = table["complete"] & table["peak_frequency_error_percent"].notna()
        part["complete"] = has_errors.groupby(table["joint"]).all()
        part["cpu_s_of_all"] = part["cpu_s"].iloc[0]
        parts.append(part.iloc[1:])
    by_joint = pd.concat(parts).groupby(level=0, sort=False)
    has_errors = by_joint.max()
    for name in ("cpu_s", "cpu_s_of_all"):
        has_errors[name] = by_joint[name].mean()
    has_errors["complete"] = by_joint["complete"].all()
    names = [JointName(joint) for joint in has_errors.index]
    has_errors["kind"] = [_kind_of_reduction(name) for name in names]
    has_errors["number"] = [str(name.count if name.pairs is None else name.pairs) for name in names]
    return has_errors


def _kind_of_reduction(joint: JointName) -> str:
    if joint.pairs is not None:
        return "weighted pairs"
    words = {"regions": "bands", "clusters": "clusters"}[str(joint.division)]
    if joint.reduction is None:
        return words
    count = f" {joint.elements}" if joint.elements else ""
    return f"{words}, {joint.reduction}{count}"


def _plot_errors_over_time(axes: Axes, rows: pd.DataFrame, what: str, colour: str) -> None:
    error = rows[f"peak_{what}_error_percent"]
    # a number that a tolerance decides is none of the series
    series = rows["number"] != "auto"
    axes.loglog(rows["cpu_s"][series], error[series], color=colour, linewidth=1.1)
    for row, value in zip(rows.itertuples(), error, strict=True):
        marker = "o" if row.complete else "X"
        axes.loglog(row.cpu_s, value, marker, color=colour, markersize=4)
        if row.number:
            add_point_label(axes, row.number, (row.cpu_s, value), colour)


def _plot_over_vectors(axes: Axes, table: pd.DataFrame, error: str, level: str, label: str) -> None:
    """Draw an error over the vectors of a basis: a line for each level and kind of basis."""
    levels = table[level].unique()
    enriched = table["basis"].map(lambda name: Basis(name).is_contact_adapted)
    for value, colour in zip(levels, level_colours(len(levels)), strict=True):
        for kind, style in zip((True, False), COORDINATE_LINES, strict=False):
            rows = table[(table[level] == value) & (enriched == kind)].sort_values("vectors")
            size = rows[error].abs()
            style = {"color": colour, "linewidth": 1.1, "markersize": 4, **style}
            words = label.format(value) if kind else None
            # the error of the largest basis is zero by definition
            axes.loglog(rows["vectors"][size > 0], size[size > 0], label=words, **style)
    ticks = sorted(table["vectors"].unique())
    axes.set_xticks(ticks, ticks)
    axes.minorticks_off()
    axes.set_xlabel("vectors of the basis")
    axes.grid(True)


def _add_legend_of_bases(panels: Sequence[Axes]) -> None:
    """Add a legend below: levels by their colour, kinds of basis by their line."""
    handles, labels = panels[0].get_legend_handles_labels()
    kinds = [Line2D([], [], color="0.3", markersize=4, **style) for style in COORDINATE_LINES[:2]]
    panels[0].figure.legend(
        [*handles, *kinds],
        [*labels, "enriched", "free"],
        loc="outside lower center",
        ncols=min(len(handles) + 2, 6),
    )
