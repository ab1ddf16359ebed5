"""Style, colours and labels that all figures share."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.path import Path as Shape
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from boltjoint.names import coordinates_in_words, joint_in_words
from boltjoint.structure.half_lap.mesh import HEXAHEDRON_FACES

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


#: a logarithmic axis with a larger ratio of its ends is labelled at powers of ten only
_MANY_DECADES = 1e3


#: levels of force or displacement; ends before the yellow that white paper swallows
_LEVELS = ("plasma", 0.0, 0.85)


REFERENCE_LINE = {"linewidth": 1.1, "zorder": 3}


MODEL_LINE = {"linewidth": 4.0, "alpha": 0.45, "zorder": 2}


BREAK_MARK = {
    "marker": "X",
    "markeredgecolor": "black",
    "markeredgewidth": 0.7,
    "linestyle": "none",
}


#: bar A, bar B, bolts
PART_COLOURS = ("#b9cfe4", "#e6d3b3", "#4d4d4d")


#: neighbouring regions differ; they are numbered, so colours may come again
REGION_COLOURS = ("#4477aa", "#ee9944", "#228833", "#cc6677", "#66ccee", "#997700", "#aa3377")


#: coordinates in the order in which they come: linear modes, response-dependent ones
COORDINATE_LINES = (
    {"linestyle": "-", "marker": "o"},
    {"linestyle": "--", "marker": "s"},
    {"linestyle": ":", "marker": "^"},
    {"linestyle": "-.", "marker": "D"},
)


BLANK_COLOUR = "0.87"


#: points closer than this [m] are one
SAME_POINT = 1e-9


MM, UM = 1e3, 1e6


styled = matplotlib.rc_context(STYLE)


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure as SVG, the same bytes for the same content; its folder is made.

    Axes that have nothing to show say so.
    """
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(STYLE):
        _say_where_empty(figure)
        figure.savefig(path, format="svg", bbox_inches="tight", metadata={"Date": None})


def _say_where_empty(figure: Figure) -> None:
    """Say that there are no results where a logarithmic axis has no number to span."""
    for name, at in (("x", 0), ("y", 1)):
        empty = [
            axes
            for axes in figure.axes
            if getattr(axes, f"get_{name}scale")() == "log"
            and not np.isfinite(axes.dataLim.minpos[at])
        ]
        for axes in empty:
            if not axes.texts:
                axes.text(0.5, 0.5, "no results", transform=axes.transAxes, ha="center")
            shared = getattr(axes, f"get_shared_{name}_axes")().get_siblings(axes)
            if all(each in empty for each in shared):
                axes.set(**{f"{name}scale": "linear", f"{name}ticks": []})


def add_legends(
    axes: Axes,
    lines: Mapping[str, Mapping[str, object]],
    quantity: str,
    levels: Sequence[str],
    marks: Mapping[str, Mapping[str, object]] | None = None,
) -> None:
    """Say above the axes which line is which, and beside them which colour is which level."""
    handles = [Line2D([], [], color="0.15", **style) for style in lines.values()]
    for mark in (marks or {}).values():
        handles.append(Line2D([], [], color="0.4", markersize=7, **mark))
    axes.legend(handles, [*lines, *(marks or {})], loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    axes.figure.legend(
        [Line2D([], [], color=colour, linewidth=3) for colour in level_colours(len(levels))],
        levels,
        title=quantity,
        loc="outside right upper",
        alignment="left",
    )


def method_in_words(joint: str, coordinates: str) -> str:
    """Name of a method for people: ``6 regions of 7 elements, 1 RDNM``."""
    return f"{joint_in_words(joint)}, {coordinates_in_words(coordinates, short=True)}"


def share_in_percent(share: float) -> str:
    """Share in whole percent; only nothing is 0 %, and only all is 100 %."""
    if 0 < share < 0.01:
        return "<1 %"
    return ">99 %" if 0.99 < share < 1 else f"{100 * share:.0f} %"


def level_colours(count: int) -> NDArray[np.float64]:
    name, darkest, lightest = _LEVELS
    return matplotlib.colormaps[name](np.linspace(darkest, lightest, count))


def positions_of(dataset: xr.Dataset, name: str, along: str) -> NDArray[np.float64]:
    return dataset[name].transpose(along, "axis").to_numpy()


def section_outlines(
    assembly: xr.Dataset, side_view: NDArray[np.float64]
) -> dict[int, list[NDArray[np.int64]]]:
    """Outlines, as loops of nodes, of every part where the plane y = 0 cuts the assembly."""
    on_plane = np.abs(assembly["coordinate"].sel(axis="y").to_numpy()) < SAME_POINT
    faces, part = faces_among_nodes(assembly, on_plane)
    if len(faces) == 0:
        raise ValueError("the mesh has no faces in the plane y = 0")
    faces = counter_clockwise(faces, side_view)
    return {int(p): outline_loops(faces[part == p]) for p in np.unique(part)}


def faces_among_nodes(
    assembly: xr.Dataset, chosen: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces of the elements with all four corners among the chosen nodes, each once.

    Returns the nodes of the faces, shape (faces, 4), and their parts, shape (faces,).
    """
    faces, part = element_faces(assembly)
    found = np.flatnonzero(chosen[faces].all(axis=1))
    _, first = np.unique(np.sort(faces[found]), axis=0, return_index=True)
    found = found[np.sort(first)]
    return faces[found], part[found]


def label_decades(axes: Axes) -> None:
    """Plain numbers on the logarithmic vertical axis, also within decades where they are few."""
    low, high = axes.get_ylim()
    if high < _MANY_DECADES * low:
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())


def element_faces(assembly: xr.Dataset) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces of all elements: nodes, shape (faces, 4), and part, shape (faces,)."""
    connectivity = assembly["connectivity"].transpose("element", "corner").to_numpy()
    faces = connectivity[:, HEXAHEDRON_FACES]
    return faces.reshape(-1, 4), np.repeat(assembly["part"].to_numpy(), faces.shape[1])


def counter_clockwise(polygon: NDArray[np.int64], point: NDArray[np.float64]) -> NDArray[np.int64]:
    """Polygons, shape (polygons, corners), turned so that all run the same way round."""
    return np.where(polygon_area(point[polygon])[:, None] < 0, polygon[:, ::-1], polygon)


def polygon_area(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area of polygons from their corners, shape (..., corners, 2); negative for clockwise ones."""
    x, y = np.moveaxis(corner, -1, 0)
    return (x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1)).sum(axis=-1) / 2


def polygon_edges(polygon: NDArray[np.int64]) -> NDArray[np.int64]:
    """Both ends of all edges of polygons, one polygon after another, shape (edges, 2)."""
    return np.stack([polygon, np.roll(polygon, -1, axis=1)], axis=-1).reshape(-1, 2)


def outline_loops(polygon: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Outline of polygons that share corners, as loops of points; loops around holes run back."""
    edges = polygon_edges(polygon).tolist()
    inside = {(end, begin) for begin, end in edges}
    following = defaultdict(list)
    for begin, end in edges:
        if (begin, end) not in inside:
            following[begin].append(end)
    loops = []
    for begin in list(following):
        while following[begin]:
            loop = [begin]
            while (end := following[loop[-1]].pop()) != begin:
                loop.append(end)
            loops.append(np.array(loop))
    return loops


def fill_shapes(axes: Axes, shapes: Sequence[Shape], **look: object) -> None:
    axes.add_collection(PathCollection(shapes, **{"linewidths": 0, **look}))
