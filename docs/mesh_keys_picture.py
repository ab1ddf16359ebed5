"""Draw the keys of a half lap's dimensions and mesh where they act, on the mesh itself.

``python docs/mesh_keys_picture.py`` writes ``docs/figures/mesh_keys.svg``.
"""

from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Shape
from mesh_keys_views import Dimension, Place, View, views_of
from numpy.typing import NDArray

from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.strict_yaml import read_mapping
from boltjoint.report.figures.outlines import closed_shape, long_lines, outline_loops
from boltjoint.report.figures.style import figure_style
from boltjoint.structure.makers.half_lap.figures import PART_COLOURS

Points = NDArray[np.float64]

HERE = Path(__file__).parent
ASSEMBLIES = HERE.parent / "config/assemblies"
#: of three bolts, and the same with washers
DRAWN = "three_bolt", "three_bolt_aluminium"
#: size of the figure, and for each view its origin and the length of a millimetre [inch]
_SIZE = 8.4, 8.0
_SCALES = ((0.65, 6.85, 0.0178), (0.65, 3.75, 0.075), (0.65, 0.15, 0.075), (6.2, 0.95, 0.105))
#: texts stay texts, in fonts of the same width wherever they are shown
_FONTS = {"svg.fonttype": "none", "font.family": ["DejaVu Sans Mono", "monospace"]}
#: bolts are lighter than in other figures, so that their elements are seen
_COLOURS = PART_COLOURS | {"bolts": "#b8b8b8", "washers": "#cfc5b8"}
_COUNT, _LENGTH = "#b2182b", "black"
_TEXT_SIZE = 7.2
_TITLE_FONTS = ["DejaVu Sans", "sans-serif"]


def views() -> tuple[View, ...]:
    """The views that are drawn, of assemblies that come with boltjoint."""
    return views_of(*(LapJoint(**read_mapping(ASSEMBLIES / f"{name}.yaml")) for name in DRAWN))


def picture(drawn: tuple[View, ...]) -> Figure:
    """The figure of all views."""
    with matplotlib.rc_context(_FONTS):
        figure = plt.figure(figsize=_SIZE)
        at = {"x": 0.98, "ha": "right", "size": _TEXT_SIZE, "family": _TITLE_FONTS}
        figure.text(y=0.975, s="lengths", color=_LENGTH, **at)
        figure.text(y=0.955, s="numbers of elements", color=_COUNT, **at)
        for view, (left, low, scale) in zip(drawn, _SCALES, strict=True):
            axes = _axes_to_scale(figure, view, (left, low), scale)
            _draw_mesh(axes, view)
            _write_title(axes, view)
            for dimension in view.dimensions:
                _draw_dimension(axes, dimension)
    return figure


def _axes_to_scale(figure: Figure, view: View, corner: Place, scale: float) -> Axes:
    """Axes over the whole figure in which the window of a view has its corner and scale."""
    axes = figure.add_axes((0, 0, 1, 1))
    ends = [
        (low - place / scale, low + (size - place) / scale)
        for (low, _), place, size in zip(view.window, corner, _SIZE, strict=True)
    ]
    axes.set(xlim=ends[0], ylim=ends[1])
    axes.axis("off")
    return axes


def _draw_mesh(axes: Axes, view: View) -> None:
    """Fill the parts in the window, with the lines of the mesh."""
    (left, right), (low, high) = view.window
    window = plt.Rectangle((left, low), right - left, high - low, transform=axes.transData)
    point, centre = view.cut.point, view.cut.point[view.cut.face].mean(axis=1)
    seen = (abs(centre - [left, low]) + abs(centre - [right, high])).T
    within = (seen[0] < right - left + 10) & (seen[1] < high - low + 10)
    for kind, colour in _COLOURS.items():
        face = view.cut.face[within & (view.cut.kind == kind)]
        if not len(face):
            continue
        outline = closed_shape(point, outline_loops(face))
        lines = Shape.make_compound_path(*(Shape(point[line]) for line in long_lines(face)))
        for shape, style in (
            (outline, {"fc": colour, "ec": "none"}),
            *([(lines, {"fc": "none", "ec": "0.35", "lw": 0.3})] if view.has_lines else []),
            (outline, {"fc": "none", "ec": "0.15", "lw": 0.7}),
        ):
            axes.add_patch(PathPatch(shape, **style)).set_clip_path(window)
    for middle, radius in view.circles:
        axes.add_patch(plt.Circle(middle, radius, fc="none", ec="0.15", lw=0.9))
    axes.vlines(view.edges, low, high, colors="0.15", linewidths=0.9)


def _write_title(axes: Axes, view: View) -> None:
    """Write what a view shows, above all else in it."""
    lines = [d.begin[1] + d.apart for d in view.dimensions if not d.is_upright]
    places = [d.text[1] for d in view.dimensions if d.text is not None]
    place = view.window[0][0], max(view.window[1][1], *lines, *places)
    axes.annotate(
        view.title, place, xytext=(0, 14), textcoords="offset points", family=_TITLE_FONTS
    )


def _draw_dimension(axes: Axes, dimension: Dimension) -> None:
    """Draw a dimension with its key."""
    colour = _COUNT if dimension.counts_elements else _LENGTH
    style = {"color": colour, "linewidth": 0.5}
    node = np.array([dimension.begin, dimension.end])
    across = 0 if dimension.is_upright else 1
    line = node.copy()
    line[:, across] = node[0, across] + dimension.apart
    middle = line.mean(axis=0)
    if dimension.tip is not None:
        axes.annotate("", dimension.tip, dimension.text, arrowprops=style | _arrow("-|>"))
    else:
        _draw_line(axes, node, line, style)
        if dimension.leader:
            axes.plot(*np.array([middle, dimension.text]).T, **style)
    _write(axes, dimension, middle, colour)


def _draw_line(axes: Axes, node: Points, line: Points, style: dict[str, object]) -> None:
    """Draw a dimension line, and extension lines from its nodes if it lies beside them."""
    if np.allclose(node, line):
        axes.plot(*line.T, color="white", linewidth=2.5, alpha=0.8)  # on the mesh
    axes.annotate("", line[1], line[0], arrowprops=style | _arrow("<|-|>"))
    for begin, end in zip(node, line, strict=True):
        over = end + 0.6 * np.sign(end - begin)
        if not np.allclose(begin, end):
            axes.plot(*np.array([begin, over]).T, **style | {"linewidth": 0.35})


def _arrow(heads: str) -> dict[str, object]:
    return {"arrowstyle": f"{heads},head_width=.12,head_length=.25", "shrinkA": 0, "shrinkB": 0}


def _write(axes: Axes, dimension: Dimension, middle: Points, colour: str) -> None:
    """Write the key of a dimension at its place, or beside the middle of its line."""
    label = "⌀ " + dimension.label if dimension.tip is not None else dimension.label
    style = {"color": colour, "size": _TEXT_SIZE}
    style["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}
    if dimension.text is None:
        outwards = 1 if dimension.apart > 0 else -1
        style |= {"ha": "center", "va": "bottom" if outwards > 0 else "top"}
        style |= {"textcoords": "offset points", "xytext": (0, 1.5 * outwards)}
        if dimension.is_upright:
            style |= {"rotation": 90, "xytext": (2.5 * outwards, 0), "va": "center"}
            style["ha"] = "left" if outwards > 0 else "right"
        axes.annotate(label, middle, **style)
        return
    beside = {"left": 2, "center": 0, "right": -2}[dimension.align] if dimension.leader else 0
    style |= {"ha": dimension.align, "textcoords": "offset points", "xytext": (beside, 0)}
    level = dimension.leader or dimension.is_upright
    axes.annotate(label, dimension.text, va="center" if level else "bottom", **style)


@figure_style
def draw(path: Path) -> None:
    """Write the picture."""
    figure = picture(views())
    with matplotlib.rc_context(_FONTS):
        figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    draw(HERE / "figures/mesh_keys.svg")
