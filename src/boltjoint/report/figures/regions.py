"""Figure of the regions of a joint: where they are, and what each of them carries."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from matplotlib.text import Text
from numpy.typing import NDArray

from boltjoint.report.figures.contact import draw_profile, set_plan_view
from boltjoint.report.figures.outlines import ContactSurface
from boltjoint.report.figures.style import (
    BLANK_COLOUR,
    MM,
    REGION_COLOURS,
    figure_style,
    fill_shapes,
)

#: least distance of texts from each other, and from what is above them [pixel]
_CLEARANCE = 3.0


@figure_style
def plot_regions(assembly: xr.Dataset, joint: xr.Dataset) -> Figure:
    """Regions of a joint in plan view, with the number of elements and share of load of each.

    Under variable normal load, open pairs have elements as well and are drawn pale. The pressure
    along the middle of the width, by which such joints may be divided, is then drawn too, with the
    part of each region. Bars are at the middle of their regions, or beside it where their texts
    would overlap.

    Parameters
    ----------
    assembly
        As ``build_assembly`` returns it.
    joint
        A joint of regions (``joint.nc``) on that assembly.

    Raises
    ------
    ValueError
        If an element lies on no contact pair of the assembly.
    """
    surface = ContactSurface.of(assembly)
    pair = surface.pairs_at(joint)
    region, slip = joint["point_of_element"].to_numpy(), joint["slip_force"].to_numpy()
    loaded = slip > 0
    load_varies = "normal_load" in joint
    count, under_load = np.bincount(region), np.bincount(region, loaded).astype(int)
    # with one friction coefficient, slip forces are in proportion to normal loads
    share = 100 * np.bincount(region, slip) / slip.sum()
    figure = Figure(figsize=(8, 6.6 if load_varies else 4.2), layout="compressed")
    panels = figure.subplots(3 if load_varies else 2, 1, sharex=True)
    plan, bars = panels[:2]
    fill_shapes(plan, [surface.area_without(pair)], facecolors=BLANK_COLOUR)
    areas = [surface.area_of(pair[region == number]) for number in range(count.size)]
    extents = np.array([area.get_extents().intervalx for area in areas])
    columns = []
    for number, (x, percent) in enumerate(zip(extents.mean(axis=1), share, strict=True)):
        style = {"color": REGION_COLOURS[number % len(REGION_COLOURS)], "linewidth": 0}
        fill_shapes(plan, [areas[number]], **style)
        above = {"ha": "center", "va": "bottom"}
        top = surface.corner[:, 1].max() + 1
        name = plan.text(x, top, number + 1, weight="bold", **above)
        (bar,) = bars.bar(x, percent, 1.0, **style)
        elements = f"{under_load[number]} of {count[number]}" if load_varies else f"{count[number]}"
        columns.append((name, bar, bars.text(x, percent, f"{elements}\n{percent:.1f} %", **above)))
    set_plan_view(plan, surface)
    bars.set_ylabel("share of the\nnormal load (%)")
    elements = "elements under load of all elements" if load_varies else "number of elements"
    bars.set_title(f"{elements} and share of the normal load of each region")
    if load_varies:
        fill_shapes(plan, [surface.area_of(pair[~loaded])], facecolors="white", alpha=0.6)
        load = np.zeros(len(surface.position))
        load[pair] = np.maximum(joint["normal_load"].to_numpy(), 0.0)
        pressure = load / assembly["area"].to_numpy() / 1e6
        cuts = (extents[1:, 0] + extents[:-1, 1]) / 2
        _fill_regions_of_profile(panels[2], surface, pressure, cuts)
        draw_profile(panels[2], surface, pressure)
        panels[2].set_ylabel("pressure (MPa)")
        patches = [Patch(color=REGION_COLOURS[0], linewidth=0, alpha=alpha) for alpha in (1.0, 0.4)]
        where = {"loc": "outside upper center", "ncols": 2}
        figure.legend(patches, ["pairs under load", "open pairs"], **where)
    panels[-1].set_xlabel(surface.labels[0])
    _place_columns(figure, bars, columns)
    return figure


def _place_columns(
    figure: Figure, axes: Axes, columns: Sequence[tuple[Text, Rectangle, Text]]
) -> None:
    """Turn and move names, bars and texts of regions until they are apart and below the title."""
    names, rectangles, texts = zip(*columns, strict=True)
    figure.draw_without_rendering()
    middle = np.array([text.get_position()[0] for text in texts])
    scale = axes.bbox.width / np.ptp(axes.get_xlim())
    width = np.array([text.get_window_extent().width for text in texts])
    order = np.argsort(middle, kind="stable")
    between = np.diff(middle[order]) * scale
    if np.any(between < (width[order][1:] + width[order][:-1]) / 2 + _CLEARANCE):
        for text in texts:
            text.set(text=f" {text.get_text().replace(chr(10), ', ')}", rotation=90)
    extents = [text.get_window_extent() for text in (*names, *texts)]
    if texts[0].get_rotation():
        least = (max(extent.width for extent in extents) + _CLEARANCE) / scale
        middle[order] = _spread(middle[order], least)
    widest = 0.8 * np.diff(np.sort(middle)).min(initial=np.ptp(axes.get_xlim()))
    for x, name, rectangle, text in zip(middle, names, rectangles, texts, strict=True):
        name.set_x(x)
        text.set_x(x)
        rectangle.set(x=x - widest / 2, width=widest)
    height = axes.bbox.height - _CLEARANCE
    room = np.array([text.get_window_extent().height for text in texts]) / height
    share = np.array([rectangle.get_height() for rectangle in rectangles])
    axes.set_ylim(0, np.max(share / np.maximum(1 - room, 0.1)))


def _spread(place: NDArray[np.float64], least: float) -> NDArray[np.float64]:
    """Places in increasing order, moved apart to a least distance, each as little as others."""
    steps = least * np.arange(place.size)
    excess = place - steps
    up = np.maximum.accumulate(excess)
    down = np.minimum.accumulate(excess[::-1])[::-1]
    return (up + down) / 2 + steps


def _fill_regions_of_profile(
    axes: Axes, surface: ContactSurface, value: NDArray[np.float64], cuts: NDArray[np.float64]
) -> None:
    """Fill the part of each region under the profile, which is straight across the holes."""
    pairs = np.unique(surface.edges_along_middle())
    if not pairs.size:
        return
    pairs = pairs[np.argsort(surface.place[pairs, 0])]
    x = surface.place[pairs, 0] * MM
    ends = np.concatenate([x[:1], cuts, x[-1:]])
    for number, (begin, end) in enumerate(pairwise(ends)):
        part = np.unique(np.clip(x, begin, end))
        colour = REGION_COLOURS[number % len(REGION_COLOURS)]
        height = np.interp(part, x, value[pairs])
        axes.fill_between(part, height, color=colour, alpha=0.45, linewidth=0)
