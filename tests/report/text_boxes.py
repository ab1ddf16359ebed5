"""The boxes of texts in figures, which must not overlap, and must be in the picture."""

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import combinations

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import NDArray

from boltjoint.report.figures.style import STYLE

#: pixels by which boxes may overlap: a box has the height of its tallest letters, which
#: neighbours rarely share
TOLERANCE = 1.0


def text_boxes(figure: Figure) -> list[tuple[str, NDArray[np.float64]]]:
    """The texts that are drawn in a figure, and the corners of each [pixel].

    Texts that are invisible, empty or no longer among the ticks of their axis are not drawn.
    """
    drawn: list[tuple[str, NDArray[np.float64]]] = []
    draw = Text.draw

    def record(text, renderer, *args, **kwargs):
        if text.get_visible() and text.get_text().strip():
            drawn.append((text.get_text(), _corners(text, renderer)))
        return draw(text, renderer, *args, **kwargs)

    Text.draw = record
    try:
        with rc_context(STYLE):
            figure.draw_without_rendering()
    finally:
        Text.draw = draw
    return drawn


def faults(figure: Figure) -> list[str]:
    """Texts of a figure that overlap, or are not wholly in the picture that is saved of it."""
    boxes = text_boxes(figure)
    # a figure is saved as large as what is in it
    with rc_context(STYLE):
        picture = figure.get_tightbbox().padded(TOLERANCE / figure.dpi)
    low, high = picture.get_points() * figure.dpi
    return [
        f"{one!r} overlaps {other!r}"
        for (one, first), (other, second) in combinations(boxes, 2)
        if _overlap(first, second) > TOLERANCE
    ] + [
        f"{text!r} is cut off"
        for text, corners in boxes
        if (corners < low).any() or (corners > high).any()
    ]


@contextmanager
def readable_figures() -> Iterator[list[Figure]]:
    """Check the texts of all figures that are made meanwhile."""
    made: list[Figure] = []
    begin = Figure.__init__

    def record(figure, *args, **kwargs):
        begin(figure, *args, **kwargs)
        made.append(figure)

    Figure.__init__ = record
    try:
        yield made
    finally:
        Figure.__init__ = begin
    found = [each for figure in made for each in faults(figure)]
    assert not found, "\n".join(found)


def _corners(text: Text, renderer: object) -> NDArray[np.float64]:
    """The four corners of a text, turned as it is, without the line of an annotation."""
    angle = text.get_rotation()
    if angle % 90 == 0:
        return Text.get_window_extent(text, renderer).corners()[[0, 1, 3, 2]]
    text.set_rotation(0)
    level = Text.get_window_extent(text, renderer)
    text.set_rotation(angle)
    turned = Text.get_window_extent(text, renderer)
    half = np.array([level.width, level.height]) / 2
    corners = half * [[-1, -1], [-1, 1], [1, 1], [1, -1]]
    sin, cos = np.sin(np.deg2rad(angle)), np.cos(np.deg2rad(angle))
    middle = [(turned.x0 + turned.x1) / 2, (turned.y0 + turned.y1) / 2]
    return corners @ [[cos, sin], [-sin, cos]] + middle


def _overlap(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Depth [pixel] to which two rectangles are in each other; negative where they are apart."""
    normals = [
        [-step[1], step[0]] / np.hypot(*step)
        for box in (first, second)
        for step in np.diff(box[:3], axis=0)
    ]
    depths = []
    for normal in normals:
        ends = [(along.min(), along.max()) for along in (first @ normal, second @ normal)]
        depths.append(min(high for _, high in ends) - max(low for low, _ in ends))
    return min(depths)
