"""Figures of the contact: normal load, weighted pairs, contact states, hysteresis loops."""

from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from boltjoint.friction import contact_states
from boltjoint.report.figures.outlines import ContactSurface, positions_of
from boltjoint.report.figures.style import (
    BLANK_COLOUR,
    MM,
    MODEL_LINE,
    REFERENCE_LINE,
    UM,
    add_legends,
    figure_style,
    fill_shapes,
    label_decades,
    level_colours,
)

#: contact states in their order, told apart by those too who see no difference of red and green
#: (M. Okabe and K. Ito, Color universal design, 2008); as in ``interactive/view.js``
_STATES = ("#0072b2", "#e69f00", "#009e73", "#cc79a7")


@figure_style
def plot_contact(assembly: xr.Dataset, preload: xr.Dataset) -> Figure:
    """Pressure, normal load and gap over the contact, and the load along the middle of its width.

    Every contact pair is drawn as the area that belongs to it.

    Parameters
    ----------
    assembly
        As ``build_assembly`` returns it.
    preload
        As ``apply_preload`` returns it, of that assembly.

    Raises
    ------
    ValueError
        If the two do not hold the same contact pairs.
    """
    surface = ContactSurface.of(assembly)
    if not np.array_equal(surface.position, positions_of(preload, "position", "pair")):
        raise ValueError("assembly and preload hold different contact pairs")
    load, gap = preload["normal_load"].to_numpy(), preload["gap"].to_numpy()
    loaded = load > 0
    figure = Figure(figsize=(8, 7.6), layout="compressed")
    panels = figure.subplots(4, 1, sharex=True, height_ratios=[1, 1, 1, 1.2])
    maps = (
        ("pressure (MPa)", load / assembly["area"].to_numpy() / 1e6, loaded, "magma_r"),
        ("normal load (N)", load, loaded, "magma_r"),
        ("gap (μm)", gap * UM, ~loaded, "GnBu"),
    )
    for axes, (label, value, pairs, name) in zip(panels, maps, strict=False):
        colours = ListedColormap(matplotlib.colormaps[name](np.linspace(0.08, 1.0, 256)))
        norm = Normalize(0, value[pairs].max(initial=0) or 1)
        cells = [surface.area_of([int(pair)]) for pair in np.flatnonzero(pairs)]
        fill_shapes(axes, [surface.area_of(np.flatnonzero(~pairs))], facecolors=BLANK_COLOUR)
        fill_shapes(
            axes, cells, facecolors=colours(norm(value[pairs])), edgecolors="face", linewidths=0.2
        )
        figure.colorbar(ScalarMappable(norm, colours), ax=axes, label=label, pad=0.01, aspect=8)
        set_plan_view(axes, surface)
    total = f"{load.sum() / 1e3:.2f} kN"
    panels[0].set_title(f"{loaded.sum()} pairs carry {total} together; open pairs are grey")
    panels[2].set_title(f"{(~loaded).sum()} pairs are open; pairs that carry load are grey")
    axes = panels[3]
    draw_profile(axes, surface, load)
    axes.set(xlabel=surface.labels[0], ylabel="normal load (N)")
    return figure


@figure_style
def plot_weighted_pairs(assembly: xr.Dataset, joint: xr.Dataset) -> Figure:
    """The pairs that stand for all others in plan view, by their weight.

    Parameters
    ----------
    assembly
        As ``build_assembly`` returns it.
    joint
        A hyper-reduced joint (``joint.nc``) on that assembly.

    Raises
    ------
    ValueError
        If an element lies on no contact pair of the assembly.
    """
    surface = ContactSurface.of(assembly)
    pair = surface.pairs_at(joint)
    weight = joint["weight"].to_numpy()[joint["point_of_element"].to_numpy()]
    figure = Figure(figsize=(8, 2.4), layout="compressed")
    axes = figure.subplots()
    fill_shapes(axes, [surface.area_without(pair)], facecolors=BLANK_COLOUR)
    colours = ListedColormap(matplotlib.colormaps["magma_r"](np.linspace(0.15, 1.0, 256)))
    norm = LogNorm(weight.min(), max(weight.max(), 1.01 * weight.min()))
    cells = [surface.area_of([cell]) for cell in pair]
    fill_shapes(axes, cells, facecolors=colours(norm(weight)))
    scale = ScalarMappable(norm, colours)
    bar = figure.colorbar(scale, ax=axes, label="weight", pad=0.01, aspect=8)
    label_decades(bar.ax)
    set_plan_view(axes, surface)
    axes.set_xlabel(surface.labels[0])
    axes.set_title(
        f"{pair.size} of {len(surface.position)} pairs, each standing for {np.median(weight):.2g} "
        f"(median; {weight.min():.2g} to {weight.max():.2g})"
    )
    return figure


@figure_style
def plot_states(assembly: xr.Dataset, joint: xr.Dataset, response: xr.Dataset) -> Figure:
    """Contact state of every pair at the peak of every force level, in plan view.

    Above each panel are the shares of the elements. A level without a peak is hatched.

    Parameters
    ----------
    assembly
        As ``build_assembly`` returns it.
    joint
        A joint on that assembly whose elements sit on contact pairs (``joint.nc``).
    response
        Its response, as ``solve_response`` returns it.

    Raises
    ------
    ValueError
        If an element lies on no contact pair of the assembly, or joint and response differ in
        their number of elements.
    """
    surface = ContactSurface.of(assembly)
    pair = surface.pairs_at(joint)
    state = response["contact_state"].transpose("force", "element").to_numpy()
    if state.shape[1] != pair.size:
        raise ValueError(f"the joint has {pair.size} elements, the response {state.shape[1]}")
    without = surface.area_without(pair)
    columns = min(2, len(state))
    rows = -(-len(state) // columns)
    length, width = np.ptp(surface.place, axis=0)
    height = 0.4 + 7.2 / columns * width / length
    figure = Figure(figsize=(8, 0.9 + rows * height), layout="compressed")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    patches = [Patch(color=colour, linewidth=0) for colour in (*_STATES, BLANK_COLOUR)]
    names = [*contact_states.MEANINGS, "no element"]
    for axes, of_level, force, frequency in zip(
        panels.flat,
        state,
        response["force_level"].to_numpy(),
        response["peak_frequency"].to_numpy(),
        strict=False,
    ):
        fill_shapes(axes, [without], facecolors=BLANK_COLOUR)
        for number, colour in enumerate(_STATES):
            fill_shapes(axes, [surface.area_of(pair[of_level == number])], facecolors=colour)
        unknown = surface.area_of(pair[of_level == contact_states.UNKNOWN])
        fill_shapes(axes, [unknown], facecolors="white", edgecolors="0.6", hatch="////")
        set_plan_view(axes, surface)
        axes.label_outer()
        if np.isnan(frequency):
            axes.set_title(f"{force:g} N: no peak found", loc="left")
            continue
        axes.set_title(f"{force:g} N, {frequency:.1f} Hz", loc="left")
        share = {number: np.mean(of_level == number) for number in np.unique(of_level)}
        axes.legend(
            [patches[number] for number in share],
            [_percent(part) for part in share.values()],
            loc="lower right",
            bbox_to_anchor=(1, 1),
            borderpad=0,
            ncols=len(share),
            handlelength=0.8,
            handletextpad=0.4,
            columnspacing=0.8,
        )
    for axes in panels.flat[len(state) :]:
        axes.set_axis_off()
        panels[-2, 1].tick_params(labelbottom=True)
    figure.supxlabel(surface.labels[0], fontsize=9)
    numbers = list(np.unique(state[state != contact_states.UNKNOWN]))
    if len(pair) < len(surface.position):
        numbers.append(len(_STATES))
    figure.legend(
        [patches[number] for number in numbers],
        [names[number] for number in numbers],
        title="contact state at the peak of every force",
        loc="outside upper center",
        ncols=len(numbers),
    )
    return figure


@figure_style
def plot_loops(reduced: xr.Dataset, regions: xr.Dataset, region: int = 1) -> Figure:
    """Hysteresis loops of a region with all its elements, and with the few fitted elements.

    The normal load is that of the assembled state, so elements on open pairs carry no force.

    Parameters
    ----------
    reduced
        A reduced joint (``joint.nc``) with the loops of its fit.
    regions
        The joint of regions that it was fitted to.
    region
        Which region, from 1.

    Raises
    ------
    ValueError
        If there is no such region.
    """
    if not 1 <= region <= reduced.sizes["point"]:
        raise ValueError(f"region {region} of {reduced.sizes['point']}")
    few, many = (
        joint["slip_force"].to_numpy()[joint["point_of_element"].to_numpy() == region - 1]
        for joint in (reduced, regions)
    )
    loaded = np.count_nonzero(many)
    elements = f"all {many.size} elements"
    if loaded < many.size:
        elements = f"{loaded} of {many.size} elements under load"
    here = reduced.isel(point=region - 1).transpose(..., "loop", "sample").dropna("loop")
    amplitude = here["loop_amplitude"].to_numpy() * UM
    figure = Figure(figsize=(8, 4.8), layout="constrained")
    axes = figure.subplots()
    original, fitted = (
        f"region {region}, {elements}",
        f"{few.size} fitted element{'s'[: few.size > 1]}",
    )
    levels = [f"{a:.3g} μm" for a in amplitude]
    branches = ("loop_displacement", "loop_force_of_region", "loop_force_of_fit")
    loops = zip(*(here[name].to_numpy() for name in branches), strict=True)
    for loop, level, colour in zip(loops, levels, level_colours(len(levels)), strict=True):
        u, of_region, of_fit = (_whole_loop(branch) for branch in loop)
        axes.plot(u * UM, of_fit, color=colour, label=f"{fitted}, {level}", **MODEL_LINE)
        axes.plot(u * UM, of_region, color=colour, label=f"{original}, {level}", **REFERENCE_LINE)
    axes.set(xlabel="relative displacement (μm)", ylabel="friction force (N)")
    axes.grid(True)
    add_legends(axes, {original: REFERENCE_LINE, fitted: MODEL_LINE}, "amplitude", levels)
    return figure


def draw_profile(axes: Axes, surface: ContactSurface, value: NDArray[np.float64]) -> None:
    """Draw values of the pairs along the middle of the width, else of all; open ones are hollow."""
    edges = surface.edges_along_middle()
    x = surface.place[:, 0] * MM
    lines = [np.c_[x[edge], value[edge]] for edge in edges]
    axes.add_collection(LineCollection(lines, colors="0.6", linewidths=0.9))
    drawn = edges if len(edges) else np.arange(len(value))
    loaded = value > 0
    for state, colour, label in ((loaded, "black", "loaded"), (~loaded, "white", "open")):
        pairs = np.intersect1d(drawn, np.flatnonzero(state))
        style: dict[str, Any] = {"markersize": 3.5, "color": colour, "markeredgecolor": "black"}
        axes.plot(x[pairs], value[pairs], "o", **style, markeredgewidth=0.6, label=label)
    axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    where = "pairs along the middle of the width" if len(edges) else "all contact points"
    axes.set_title(where, loc="left")
    axes.grid(True)


def set_plan_view(axes: Axes, surface: ContactSurface) -> None:
    """Limits and label of axes in which the contact is seen from above."""
    y = surface.place[:, 1] * MM
    (left, bottom), (right, top) = surface.corner.min(axis=0), surface.corner.max(axis=0)
    axes.set_aspect("equal")
    axes.set_xlim(left - 1, right + 1)
    axes.set_ylim(bottom - 1, top + 1)
    axes.set_yticks([y.min(), (y.min() + y.max()) / 2, y.max()])
    axes.set_ylabel(surface.labels[1])


def _percent(share: float) -> str:
    """A share in whole percent; 0 % and 100 % stand for none and all only."""
    if 0 < share < 0.01:
        return "<1 %"
    return ">99 %" if 0.99 < share < 1 else f"{100 * share:.0f} %"


def _whole_loop(unloading: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacement or force over a whole loop; loading is unloading with both signs changed."""
    return np.concatenate([unloading, -unloading])
