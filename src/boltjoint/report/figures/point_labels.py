"""Labels beside points of a plot, each where it covers no other label, point or curve."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

#: distances of a label from its point, in order of preference [pt]
_DISTANCES = (3.0, 6.0, 10.0, 15.0, 21.0, 28.0)
#: directions from a point, the preferred one first [deg]
_DIRECTIONS = (45, 0, 90, 315, 135, 180, 270, 225, 22, 67, 112, 157, 202, 247, 292, 337)
#: a curve behind a label, as steps of distance
_COVERED_CURVE = 2.0
#: half the size of a mark, and the least distance of texts [pt]
_MARK, _CLEARANCE = 2.5, 0.8
#: rank of the distance, offset [pt] and box of a label
_Place = tuple[int, NDArray[np.float64], Bbox]


def add_point_label(axes: Axes, text: str, point: tuple[float, float], colour: str) -> None:
    """Add a label to a point, to which a thin line leads where the label is far from it.

    ``place_point_labels`` finds its place.
    """
    axes.annotate(
        text,
        point,
        xytext=(_DISTANCES[0], _DISTANCES[0]),
        textcoords="offset points",
        ha="center",
        va="center",
        fontsize=7,
        color=colour,
        arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.5, "shrinkA": 0},
        in_layout=False,
    )


def place_point_labels(figure: Figure) -> None:
    """Move the labels of points until none covers another one, a mark or, if possible, a curve.

    Labels are placed in the order in which they were added, each as near to its point as it can,
    within its axes. Limits of axes, and what stands around these, must be final.
    """
    figure.draw_without_rendering()
    for axes in figure.axes:
        labels = [text for text in axes.texts if isinstance(text, Annotation)]
        marks = _boxes_of_marks(axes)
        curves = _curves(axes)
        for label in labels:
            marks.append(_place(label, axes, marks, curves))


def _place(label: Annotation, axes: Axes, covered: list[Bbox], curves: list[Path]) -> Bbox:
    """Move a label to its best place; its box there."""

    def cost(place: _Place) -> tuple[int, float]:
        distance, _, box = place
        inside = all(axes.bbox.contains(*corner) for corner in box.get_points())
        overlaps = box.count_overlaps(covered) + (0 if inside else 1)
        crossed = sum(curve.intersects_bbox(box, filled=False) for curve in curves)
        return overlaps, distance + _COVERED_CURVE * crossed

    _, offset, box = min(_places(label, axes), key=cost)
    label.set_position((offset[0], offset[1]))
    return box


def _places(label: Annotation, axes: Axes) -> Iterator[_Place]:
    """Rank by distance, offset [pt] and box of each place that a label may have."""
    scale = axes.figure.dpi / 72
    # that of an annotation holds its line
    extent = Text.get_window_extent(label)
    half = np.array([extent.width, extent.height]) / scale / 2
    point = axes.transData.transform(label.xy)
    for rank, distance in enumerate(_DISTANCES):
        for angle in np.deg2rad(_DIRECTIONS):
            direction = np.array([np.cos(angle), np.sin(angle)])
            direction /= np.abs(direction).max()
            offset = direction * (half + distance)
            corners = point + scale * (offset + np.outer([-1, 1], half + _CLEARANCE / 2))
            yield rank, offset, Bbox(corners)


def _boxes_of_marks(axes: Axes) -> list[Bbox]:
    """The boxes of the marks of all lines [pixel]."""
    half = _MARK * axes.figure.dpi / 72
    points = [
        line.get_transform().transform(line.get_xydata())
        for line in axes.get_lines()
        if line.get_marker() not in ("None", "none", "", " ", None)
    ]
    return [
        Bbox(point + np.outer([-half, half], [1, 1])) for each in points for point in np.array(each)
    ]


def _curves(axes: Axes) -> list[Path]:
    """The lines of axes that are more than marks [pixel]."""
    return [
        line.get_transform().transform_path(line.get_path())
        for line in axes.get_lines()
        if line.get_linestyle() not in ("None", "none", "", " ")
        and len(np.asarray(line.get_xydata())) > 1
    ]
