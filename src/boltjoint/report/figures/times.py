"""Figures of computing times."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from boltjoint.names import Coordinates, JointName
from boltjoint.report.figures.style import (
    BREAK_MARK,
    COORDINATE_LINES,
    REGION_COLOURS,
    figure_style,
    label_decades,
    method_label,
)

_TIME_LINE = {"linewidth": 1.1, "markersize": 3.5}
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
            complete = rows["complete"].astype(bool)
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
    plain = {"color": "0.4"}
    entries = {JointName(j).label: Line2D([], [], color=c, lw=3) for j, c in colours.items()}
    for coordinates, style in styles.items():
        entries[Coordinates(coordinates).short_label] = Line2D(
            [], [], **plain, **style, **_TIME_LINE
        )
    if source and "forward-difference" in jacobians and times[source[1]].notna().any():
        style = {**COORDINATE_LINES[0], **_MARK_OF_SOURCE}
        entries[source[0]] = Line2D([], [], **plain, **style)
    if not times["complete"].all():
        entries["branch breaks off"] = Line2D([], [], **plain, **BREAK_MARK)
    figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=4)
    return figure
