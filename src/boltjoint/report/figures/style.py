"""Style, colours and legends that all figures share.

Colour is the level of force or displacement, from dark for the lowest to light for the highest; a
thin line is the reference, a broad pale line the reduced model; a dot is a peak, a cross the end of
a branch that broke off. Parts, regions, contact states and joints have other colours, given by
legends or numbers; grey is what the figure is not about.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.path import Path as Shape
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from boltjoint.names import Coordinates, JointName

STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.formatter.useoffset": False,
    "axes.axisbelow": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "svg.fonttype": "path",  # the same look wherever it is opened
    "svg.hashsalt": "boltjoint",  # the same identifiers on every run
}

figure_style = matplotlib.rc_context(STYLE)

REFERENCE_LINE: Mapping[str, Any] = {"linewidth": 1.1, "zorder": 3}
MODEL_LINE: Mapping[str, Any] = {"linewidth": 4.0, "alpha": 0.45, "zorder": 2}
BREAK_MARK: Mapping[str, Any] = {"marker": "X", "mec": "black", "mew": 0.7, "linestyle": "none"}
#: kinds of coordinates in the order in which they occur
COORDINATE_LINES: tuple[Mapping[str, Any], ...] = (
    {"linestyle": "-", "marker": "o"},
    {"linestyle": "--", "marker": "s"},
    {"linestyle": ":", "marker": "^"},
    {"linestyle": "-.", "marker": "D"},
)
#: neighbouring regions differ; they are numbered, so colours may repeat
REGION_COLOURS = ("#4477aa", "#ee9944", "#228833", "#cc6677", "#66ccee", "#997700", "#aa3377")
BLANK_COLOUR = "0.87"
#: levels of force or displacement; yellow is left out as it is faint on white paper
_LEVELS = ("plasma", 0.0, 0.85)
#: a logarithmic axis with a larger ratio of its ends is labelled at powers of ten only
_MOST_LABELLED = 1e3
#: millimetres and micrometres of a metre
MM, UM = 1e3, 1e6


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure as SVG, the same bytes for the same content, and make its folder.

    Axes without data are marked.
    """
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(STYLE):
        _mark_empty_axes(figure)
        figure.savefig(path, format="svg", bbox_inches="tight", metadata={"Date": None})


def _mark_empty_axes(figure: Figure) -> None:
    """Write "no results" on axes with a logarithmic scale and no positive data."""
    for name, at in (("x", 0), ("y", 1)):
        empty = [
            axes
            for axes in figure.axes
            if getattr(axes, f"get_{name}scale")() == "log"
            and not np.isfinite(np.atleast_1d(axes.dataLim.minpos)[at])
        ]
        for axes in empty:
            if not axes.texts:
                axes.text(0.5, 0.5, "no results", transform=axes.transAxes, ha="center")
            shared = getattr(axes, f"get_shared_{name}_axes")().get_siblings(axes)
            if all(panel in empty for panel in shared):
                axes.set(**{f"{name}scale": "linear", f"{name}ticks": []})


def add_legends(
    axes: Axes,
    lines: Mapping[str, Mapping[str, Any]],
    quantity: str,
    levels: Sequence[str],
    marks: Mapping[str, Mapping[str, Any]] | None = None,
) -> None:
    """Add a legend of lines and marks above the axes, and one of levels beside them."""
    handles = [Line2D([], [], color="0.15", **style) for style in lines.values()]
    for mark in (marks or {}).values():
        handles.append(Line2D([], [], color="0.4", markersize=7, **mark))
    axes.legend(handles, [*lines, *(marks or {})], loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    axes.figure.legend(
        [Line2D([], [], color=colour, linewidth=3) for colour in level_colours(len(levels))],
        levels,
        title=quantity,
        # below the top of the axes: the legend above them may be wider than they are
        loc="outside right center",
        alignment="left",
    )


def level_colours(count: int) -> NDArray[np.float64]:
    """Colours of levels of force or displacement, from the lowest."""
    name, darkest, lightest = _LEVELS
    return matplotlib.colormaps[name](np.linspace(darkest, lightest, count))


def label_decades(axes: Axes, which: Literal["x", "y"] = "y") -> None:
    """Label a logarithmic axis with plain numbers, within decades if these are few."""
    axis, (low, high) = getattr(axes, f"{which}axis"), getattr(axes, f"get_{which}lim")()
    if high < _MOST_LABELLED * low:
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def fill_shapes(axes: Axes, shapes: Sequence[Shape], **style: Any) -> None:  # noqa: ANN401
    """Fill shapes without lines around them, unless the style has them."""
    style = {"linewidths": 0, **style}
    axes.add_collection(PathCollection(shapes, **style))


def method_label(joint: str, coordinates: str) -> str:
    """Label of a method, such as ``6 regions of 7 elements, 1 RDNM``."""
    return f"{JointName(joint).label}, {Coordinates(coordinates).short_label}"
