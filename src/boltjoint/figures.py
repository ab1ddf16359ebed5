"""What do the results look like? One function a figure, from datasets to a matplotlib figure.

One language throughout: colour tells the level of force or displacement, from dark for the lowest
to light for the highest; a thin line is the reference, a broad pale line the model that stands in
for it; a dot is a peak, a cross the place where a branch broke off. Parts, regions, contact states
and joints have colours of their own, told by legends or numbers; grey is what takes no part.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import Colormap, ListedColormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Polygon, Rectangle
from matplotlib.path import Path as Shape
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, KDTree

from boltjoint import joint as joints
from boltjoint.friction import states
from boltjoint.names import coordinates_in_words, is_enriched, joint_in_words
from boltjoint.structure.mesh import FIRST_BOLT, HEXAHEDRON_FACES

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

_REFERENCE = {"linewidth": 1.1, "zorder": 3}
_MODEL = {"linewidth": 4.0, "alpha": 0.45, "zorder": 2}
_PEAK = {"marker": "o", "markeredgecolor": "white", "markeredgewidth": 0.6, "linestyle": "none"}
_HIDDEN = {"linestyle": (0, (2.5, 1.5)), "marker": "none", "dash_capstyle": "butt"}
_BREAK = {"marker": "X", "markeredgecolor": "black", "markeredgewidth": 0.7, "linestyle": "none"}
_SOLVED = {"linewidth": 1.1, "markersize": 3.5}
_PUBLISHED = {"linestyle": "none", "markersize": 7, "markerfacecolor": "none"}

#: bar A, bar B, bolts
_PARTS = ("#b9cfe4", "#e6d3b3", "#4d4d4d")
#: neighbouring regions differ; they are numbered, so colours may come again
_REGIONS = ("#4477aa", "#ee9944", "#228833", "#cc6677", "#66ccee", "#997700", "#aa3377")
#: coordinates in the order in which they come: linear modes, response-dependent ones
_COORDINATES = (
    {"linestyle": "-", "marker": "o"},
    {"linestyle": "--", "marker": "s"},
    {"linestyle": ":", "marker": "^"},
    {"linestyle": "-.", "marker": "D"},
)
#: contact states in their order, in the source's red, blue, cyan and green; their lightness differs
#: enough to tell them apart without seeing red or green
_STATES = ("#b8242f", "#2f5aa8", "#5cc4e8", "#7cc267")
_BLANK = "0.87"

#: largest displacement of a drawn mode over the length of the assembly
_DEFLECTION = 0.06
#: largest displacement drawn under preload, that of a cut shank's end, over the height
_OVERLAP = 0.4
#: response over its peak down to which a curve is kept in view
_FLANK = 1 / 2
#: what is shown on both sides of that, over its width and at least over the frequency
_MARGIN, _LEAST_MARGIN = 0.25, 0.02
#: response over the lowest peak down to which antiresonances are followed
_DEPTH = 1 / 30
#: where the viewer of the mesh stands, seen from the assembly; he must be above it
_VIEW = (-0.35, -1.0, 0.65)
#: where the light comes from, and how many tones it makes
_LIGHT, _TONES = np.array([-0.3, -0.5, 0.81]), 16
#: length of the arrows at force and response, and distance of dimension lines [mm]
_ARROW, _BESIDE = 25.0, 7.0
#: points closer than this [m] are one
_SAME = 1e-9

_MM, _UM = 1e3, 1e6

_styled = matplotlib.rc_context(STYLE)


def save(figure: Figure, path: str | Path) -> None:
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


@_styled
def plot_modes(assembly: xr.Dataset, modes: xr.Dataset) -> Figure:
    """Mode shapes of an assembly seen from the side, cut along the middle of its width.

    Parameters
    ----------
    assembly
        As ``structure.mesh`` builds it.
    modes
        As ``structure.modes`` finds them, of that assembly.

    Raises
    ------
    ValueError
        If the mesh has no faces in the plane y = 0.
    """
    at_rest = assembly["coordinate"].sel(axis=["x", "z"]).transpose("node", "axis").to_numpy()
    shape = modes["mode_shape"].sel(axis=["x", "z"]).transpose("mode", "node", "axis").to_numpy()
    section = _section(assembly, at_rest)
    (length, height), left = np.ptp(at_rest, axis=0), at_rest[:, 0].min()
    columns = 1 if len(shape) <= 5 else 2
    rows = -(-len(shape) // columns)
    figure = Figure(figsize=(8, 0.7 + 1.75 * rows / columns), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes in panels.flat[len(shape) :]:
        axes.set_axis_off()
    for index, displacement in enumerate(shape):
        axes = panels.flat[index]
        moved = at_rest + _DEFLECTION * length * displacement / np.abs(displacement).max()
        _draw_section(axes, section, moved, at_rest)
        axes.set_title(f"mode {index + 1}: {modes['natural_frequency'][index].item():.1f} Hz")
        axes.set_aspect("equal")
        beyond = _DEFLECTION * length * _MM
        axes.set_xlim(left * _MM - beyond / 2, (left + length) * _MM + beyond)
        axes.set_ylim(-height / 2 * _MM - beyond, height / 2 * _MM + beyond)
    figure.supxlabel("x (mm)", fontsize=9)
    figure.supylabel("z (mm), displacements enlarged", fontsize=9)
    _explain_parts(figure, at_rest=True)
    return figure


@_styled
def plot_mesh(assembly: xr.Dataset) -> Figure:
    """Mesh of an assembly with its clamp and points, and the main dimensions of the bars.

    The mesh is seen from above at an angle, without what is hidden; below it stand the contact
    surface from above and the assembly from the side, cut along the middle of its width.

    Parameters
    ----------
    assembly
        As ``structure.mesh`` builds it.

    Raises
    ------
    ValueError
        If the mesh has no faces in the plane y = 0.
    """
    figure = Figure(figsize=(8, 4.9), layout="constrained")
    view, plan, side = figure.subplots(3, 1, height_ratios=[2.6, 1, 1.5])
    side.sharex(plan)
    _draw_mesh(view, assembly)
    _draw_plan(plan, assembly)
    _draw_side(side, assembly)
    for axes, title in (
        (view, f"{assembly.sizes['element']} elements, {assembly.sizes['node']} nodes"),
        (plan, "contact surface from above, lengths in mm"),
        (side, "cut along the middle of the width, lengths in mm"),
    ):
        axes.set_title(title, loc="left")
        axes.set_aspect("equal")
        axes.margins(0.02)
        axes.autoscale_view()
        axes.set_axis_off()
    _explain_parts(figure)
    return figure


@_styled
def plot_deformation(assembly: xr.Dataset, preload: xr.Dataset) -> Figure:
    """Assembly with tight bolts seen from the side, cut along the middle, displacements enlarged.

    The ends of every cut shank lie over one another by what tightening has shortened it.

    Parameters
    ----------
    assembly
        As ``structure.mesh`` builds it.
    preload
        As ``structure.statics`` finds it, of that assembly.

    Raises
    ------
    ValueError
        If the two do not hold the same nodes, or the mesh has no faces in the plane y = 0.
    """
    if assembly.sizes["node"] != preload.sizes["node"]:
        raise ValueError("assembly and preload hold different nodes")
    at_rest = _positions(assembly, "coordinate", "node")[:, [0, 2]]
    displacement = _positions(preload, "displacement", "node")[:, [0, 2]]
    section = _section(assembly, at_rest)
    scale = _round_down(_OVERLAP * np.ptp(at_rest[:, 1]) / np.abs(displacement).max())
    moved = at_rest + scale * displacement
    x = assembly["position"].sel(axis="x").to_numpy()
    margin = 0.15 * np.ptp(x)
    whole = at_rest[:, 0].min(), at_rest[:, 0].max()
    views = {"whole assembly": whole, "lap": (x.min() - margin, x.max() + margin)}
    # each as high as its scale makes it
    heights = [1 / (high - low) for low, high in views.values()]
    figure = Figure(figsize=(8, 3.4), layout="constrained")
    panels = figure.subplots(2, 1, height_ratios=heights)
    for axes, (name, (low, high)) in zip(panels, views.items(), strict=True):
        _draw_section(axes, section, moved, at_rest)
        axes.set_aspect("equal")
        axes.set_xlim(low * _MM, high * _MM)
        axes.set_ylim(1.25 * at_rest[:, 1].min() * _MM, 1.25 * at_rest[:, 1].max() * _MM)
        axes.set_title(f"{name}, displacements × {scale:g}", loc="left")
        axes.set_ylabel("z (mm)")
    panels[-1].set_xlabel("x (mm)")
    _explain_parts(figure, at_rest=True)
    return figure


@_styled
def plot_contact(assembly: xr.Dataset, preload: xr.Dataset) -> Figure:
    """Pressure, normal load and gap over the contact, and the load along the middle of its width.

    Every contact pair is drawn as the area that belongs to it.

    Parameters
    ----------
    assembly
        As ``structure.mesh`` builds it.
    preload
        As ``structure.statics`` finds it, of that assembly.

    Raises
    ------
    ValueError
        If the two do not hold the same contact pairs.
    """
    surface = _Surface.of(assembly)
    if not np.array_equal(surface.position, _positions(preload, "position", "pair")):
        raise ValueError("assembly and preload hold different contact pairs")
    load, gap = preload["normal_load"].to_numpy(), preload["gap"].to_numpy()
    loaded = load > 0
    figure = Figure(figsize=(8, 7.6), layout="compressed")
    panels = figure.subplots(4, 1, sharex=True, height_ratios=[1, 1, 1, 1.2])
    maps = (
        ("pressure (MPa)", load / assembly["area"].to_numpy() / 1e6, loaded, "magma_r"),
        ("normal load (N)", load, loaded, "magma_r"),
        ("gap (μm)", gap * _UM, ~loaded, "GnBu"),
    )
    for axes, (label, value, shown, name) in zip(panels, maps, strict=False):
        colours = _part_of_map(name, 0.08, 1.0)
        norm = Normalize(0, value[shown].max(initial=0) or 1)
        cells = [surface.area_of([pair]) for pair in np.flatnonzero(shown)]
        _fill(axes, [surface.area_of(np.flatnonzero(~shown))], facecolors=_BLANK)
        _fill(
            axes, cells, facecolors=colours(norm(value[shown])), edgecolors="face", linewidths=0.2
        )
        figure.colorbar(ScalarMappable(norm, colours), ax=axes, label=label, pad=0.01, aspect=8)
        _plan_view(axes, surface)
    total = f"{load.sum() / 1e3:.2f} kN"
    panels[0].set_title(f"{loaded.sum()} pairs carry {total} together; open pairs are grey")
    panels[2].set_title(f"{(~loaded).sum()} pairs are open; pairs that carry load are grey")
    axes = panels[3]
    _profile(axes, surface, load)
    axes.set(xlabel="x (mm)", ylabel="normal load (N)")
    axes.set_title("pairs along the middle of the width", loc="left")
    return figure


@_styled
def plot_regions(assembly: xr.Dataset, joint: xr.Dataset) -> Figure:
    """Where the regions of a joint lie, with the number of elements and the share of load of each.

    Where the normal load varies, open pairs have elements as well and are drawn pale. The pressure
    along the middle of the width, by which such joints may be divided, is then shown with the
    part of each region.

    Parameters
    ----------
    assembly
        As ``structure.mesh`` builds it.
    joint
        A joint of regions (``joint.nc``) on that assembly.

    Raises
    ------
    ValueError
        If an element lies on no contact pair of the assembly.
    """
    surface = _Surface.of(assembly)
    pair = surface.pairs_at(joint)
    law = joints.from_dataset(joint).law
    region, loaded = law.point_of_element, law.slip_force > 0
    load_varies = "normal" in law.directions
    count, under_load = np.bincount(region), np.bincount(region, loaded).astype(int)
    # friction is the same everywhere, so slip forces stand to each other as normal loads do
    share = 100 * np.bincount(region, law.slip_force) / law.slip_force.sum()
    figure = Figure(figsize=(8, 6.6 if load_varies else 4.2), layout="compressed")
    panels = figure.subplots(3 if load_varies else 2, 1, sharex=True)
    plan, bars = panels[:2]
    without = np.setdiff1d(np.arange(len(surface.position)), pair)
    _fill(plan, [surface.area_of(without)], facecolors=_BLANK)
    areas = [surface.area_of(pair[region == number]) for number in range(count.size)]
    extents = np.array([area.get_extents().intervalx for area in areas])
    middle = extents.mean(axis=1)
    width = 0.8 * np.diff(np.sort(middle)).min(initial=np.ptp(surface.corner[:, 0]))
    many = count.size > 10
    for number, (x, percent) in enumerate(zip(middle, share, strict=True)):
        look = {"color": _REGIONS[number % len(_REGIONS)], "linewidth": 0}
        _fill(plan, [areas[number]], **look)
        above = {"ha": "center", "va": "bottom"}
        plan.text(x, surface.corner[:, 1].max() + 1, number + 1, weight="bold", **above)
        bars.bar(x, percent, width, **look)
        elements = f"{under_load[number]} of {count[number]}" if load_varies else f"{count[number]}"
        text = f" {elements}, {percent:.1f} %" if many else f"{elements}\n{percent:.1f} %"
        bars.text(x, percent, text, rotation=90 if many else 0, **above)
    _plan_view(plan, surface)
    bars.set_ylabel("share of the\nnormal load (%)")
    # room for the texts on the bars
    bars.set_ylim(0, share.max() * (1.5 if not many else 3.2 if load_varies else 1.9))
    elements = "elements under load of all elements" if load_varies else "number of elements"
    bars.set_title(f"{elements} and share of the normal load of each region")
    if load_varies:
        _fill(plan, [surface.area_of(pair[~loaded])], facecolors="white", alpha=0.6)
        load = np.zeros(len(surface.position))
        load[pair] = np.maximum(law.normal_load, 0.0)
        pressure = load / assembly["area"].to_numpy() / 1e6
        _divide_profile(panels[2], surface, pressure, (extents[1:, 0] + extents[:-1, 1]) / 2)
        _profile(panels[2], surface, pressure)
        panels[2].set_ylabel("pressure (MPa)")
        panels[2].set_title("pairs along the middle of the width", loc="left")
        patches = [Patch(color=_REGIONS[0], linewidth=0, alpha=alpha) for alpha in (1.0, 0.4)]
        where = {"loc": "outside upper center", "ncols": 2}
        figure.legend(patches, ["pairs under load", "open pairs"], **where)
    panels[-1].set_xlabel("x (mm)")
    return figure


@_styled
def plot_states(assembly: xr.Dataset, joint: xr.Dataset, response: xr.Dataset) -> Figure:
    """Contact state of every pair at the peak of every force level, in plan view.

    Above each panel stand the shares of the elements. A level without a peak is hatched.

    Parameters
    ----------
    assembly
        As ``structure.mesh`` builds it.
    joint
        A joint on that assembly whose elements sit on contact pairs (``joint.nc``).
    response
        Its response, as ``response.solve_response`` gives it.

    Raises
    ------
    ValueError
        If an element lies on no contact pair of the assembly, or joint and response differ in
        their number of elements.
    """
    surface = _Surface.of(assembly)
    pair = surface.pairs_at(joint)
    state = response["contact_state"].transpose("force", "element").to_numpy()
    if state.shape[1] != pair.size:
        raise ValueError(f"the joint has {pair.size} elements, the response {state.shape[1]}")
    without = surface.area_of(np.setdiff1d(np.arange(len(surface.position)), pair))
    columns = min(2, len(state))
    rows = -(-len(state) // columns)
    length, width, _ = np.ptp(surface.position, axis=0)
    each = 0.4 + 7.2 / columns * width / length
    figure = Figure(figsize=(8, 0.9 + rows * each), layout="compressed")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    patches = [Patch(color=colour, linewidth=0) for colour in (*_STATES, _BLANK)]
    names = [*states.MEANINGS, "no element"]
    for axes, found, force, frequency in zip(
        panels.flat,
        state,
        response["force_level"].to_numpy(),
        response["peak_frequency"].to_numpy(),
        strict=False,
    ):
        _fill(axes, [without], facecolors=_BLANK)
        for number, colour in enumerate(_STATES):
            _fill(axes, [surface.area_of(pair[found == number])], facecolors=colour)
        unknown = surface.area_of(pair[found == states.UNKNOWN])
        _fill(axes, [unknown], facecolors="white", edgecolors="0.6", hatch="////")
        _plan_view(axes, surface)
        axes.label_outer()
        if np.isnan(frequency):
            axes.set_title(f"{force:g} N: no peak found", loc="left")
            continue
        axes.set_title(f"{force:g} N, {frequency:.1f} Hz", loc="left")
        share = {number: np.mean(found == number) for number in np.unique(found)}
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
    figure.supxlabel("x (mm)", fontsize=9)
    shown = list(np.unique(state[state != states.UNKNOWN]))
    if len(pair) < len(surface.position):
        shown.append(len(_STATES))
    figure.legend(
        [patches[number] for number in shown],
        [names[number] for number in shown],
        title="contact state at the peak of every force",
        loc="outside upper center",
        ncols=len(shown),
    )
    return figure


@_styled
def plot_loops(reduced: xr.Dataset, regions: xr.Dataset, region: int = 1) -> Figure:
    """Hysteresis loops of a region: all its elements against the few fitted to them.

    The loops are those of constant normal load, that of the assembled state; elements on open pairs
    have no part in them.

    Parameters
    ----------
    reduced
        A reduced joint (``joint.nc``) with the loops of its fit.
    regions
        The joint of regions that it was fitted to.
    region
        Which region, from 1 at the clamped end.

    Raises
    ------
    ValueError
        If there is no such region.
    """
    if not 1 <= region <= reduced.sizes["point"]:
        raise ValueError(f"region {region} of {reduced.sizes['point']}")
    few, many = (
        law.slip_force[law.point_of_element == region - 1]
        for law in (joints.from_dataset(joint).law for joint in (reduced, regions))
    )
    loaded = np.count_nonzero(many)
    of_them = f"all its {many.size} elements"
    if loaded < many.size:
        of_them = f"its {loaded} elements under load, of {many.size}"
    here = reduced.isel(point=region - 1).transpose(..., "loop", "sample")
    amplitude = here["loop_amplitude"].to_numpy() * _UM
    figure = Figure(figsize=(8, 4.8), layout="constrained")
    axes = figure.subplots()
    all_of_them, fitted = f"region {region}, {of_them}", f"the {few.size} fitted to them"
    levels = [f"{a:.3g} μm" for a in amplitude]
    branches = ("loop_displacement", "loop_force_of_region", "loop_force_of_fit")
    loops = zip(*(here[name].to_numpy() for name in branches), strict=True)
    for loop, level, colour in zip(loops, levels, _level_colours(len(levels)), strict=True):
        u, of_region, of_fit = (_whole_loop(branch) for branch in loop)
        axes.plot(u * _UM, of_fit, color=colour, label=f"{fitted}, {level}", **_MODEL)
        axes.plot(u * _UM, of_region, color=colour, label=f"{all_of_them}, {level}", **_REFERENCE)
    axes.set(xlabel="relative displacement (μm)", ylabel="friction force (N)")
    axes.grid(True)
    _explain(axes, {all_of_them: _REFERENCE, fitted: _MODEL}, "amplitude", levels)
    return figure


@_styled
def plot_response(
    response: xr.Dataset, joint: str, coordinates: str, reference: xr.Dataset | None = None
) -> Figure:
    """Response over frequency at all force levels, divided by the force.

    Shown are the frequencies around those at which some response is half its peak or more. Dashed
    are solutions that a slow sweep of the frequency passes over, up and down.

    Parameters
    ----------
    response
        As ``response.solve_response`` gives it.
    joint
        Name of the joint that was solved, such as ``regions=6/elements=7``.
    coordinates
        What it was solved in, ``linear`` or ``rdnm-N``.
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
    layers = {_in_words(joint, coordinates): (response, _REFERENCE if is_reference else _MODEL)}
    if reference is not None:
        layers = {_in_words("node-to-node", "linear"): (reference, _REFERENCE)} | layers
    levels = [f"{force:g} N" for force in forces]
    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.subplots()
    shown, marks = [], {"peak": _PEAK}
    for name, (solved, style) in layers.items():
        size = 0.6 if style is _REFERENCE and not is_reference else 1.0
        curves = _curves(solved)
        for index, (curve, colour) in enumerate(
            zip(curves, _level_colours(forces.size), strict=True)
        ):
            x, y = curve.frequency, curve.amplitude
            label = f"{name}, {forces[index]:g} N"
            axes.semilogy(x, np.where(curve.hidden, np.nan, y), color=colour, label=label, **style)
            if curve.hidden.any():
                aside = _or_beside(curve.hidden)
                axes.plot(x, np.where(aside, y, np.nan), color=colour, **style, **_HIDDEN)
                marks["not shown by slow sweeps"] = {**_REFERENCE, **_HIDDEN}
            if curve.peak is not None:
                at = [curve.peak]
                axes.plot(x[at], y[at], color=colour, markersize=7 * size, zorder=4, **_PEAK)
            if curve.broken_off:
                axes.plot(x[-1:], y[-1:], color=colour, markersize=9 * size, zorder=5, **_BREAK)
                marks["branch breaks off"] = _BREAK
                levels[index] += f"\n{'reference ' if solved is reference else ''}{curve.end}"
            if curve.fell_back:
                levels[index] += "\nlinear modes instead"
        shown += curves
    _keep_in_view(axes, shown)
    axes.set(xlabel="frequency (Hz)", ylabel="response / force (mm/N)")
    axes.grid(True)
    _explain(axes, {name: style for name, (_, style) in layers.items()}, "force", levels, marks)
    return figure


@_styled
def plot_times(times: pd.DataFrame, resonance: int = 1) -> Figure:
    """Solution times over force of every joint and coordinates, by way to the Jacobian.

    Below the times stand their ratios to those of the node-to-node joint in linear modes. Published
    ratios are drawn beside those with finite differences, which the source uses.

    Parameters
    ----------
    times
        As ``compare.tabulate_times`` gives it.
    resonance
        Around which resonance.

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
    colours = dict(zip(times["joint"].unique(), ("0.15", *_REGIONS) * len(times), strict=False))
    styles = dict(zip(times["coordinates"].unique(), _COORDINATES * len(times), strict=False))
    figure = Figure(figsize=(8, 6.4), layout="constrained")
    ways = [("analytic", ""), ("forward-difference", "_forward_difference")]
    ways = [(way, ending) for way, ending in ways if times[f"cpu{ending}_s"].notna().any()]
    panels = figure.subplots(2, len(ways), sharex=True, sharey="row", squeeze=False)
    for (seconds, ratios), (way, ending) in zip(panels.T, ways, strict=True):
        for (joint, coordinates), of_one in times.groupby(["joint", "coordinates"], sort=False):
            of_one = of_one.sort_values("force_N")
            place, cpu, ratio, published = (
                of_one["place"],
                of_one[f"cpu{ending}_s"],
                1 - of_one[f"reduction{ending}_percent"] / 100,
                1 - of_one["published_reduction_percent"] / 100,
            )
            colour, style = {"color": colours[joint]}, styles[coordinates]
            label = _in_words(joint, coordinates)
            complete = of_one["complete"].astype(bool)
            seconds.plot(place, cpu.where(complete), label=label, **colour, **style, **_SOLVED)
            if not complete.all():
                seconds.plot(place[~complete], cpu[~complete], **colour, **_BREAK)
            ratios.plot(place, ratio, label=label, **colour, **style, **_SOLVED)
            if way == "forward-difference":
                look = {**style, **_PUBLISHED}
                ratios.plot(place, published, label=f"{label}, published", **colour, **look)
        seconds.set_title(f"{way} Jacobian")
        ratios.set_xticks(np.arange(forces.size), [f"{force:g}" for force in forces])
        ratios.set_xlabel("force (N)")
        for axes in (seconds, ratios):
            axes.set_yscale("log")
            _label_decades(axes)
            axes.grid(True)
    panels[0, 0].set_ylabel("processor time (s)")
    panels[1, 0].set_ylabel("over that of the node-to-node\njoint in linear modes")
    plain = {"color": "0.4"}
    entries = {joint_in_words(j): Line2D([], [], color=c, lw=3) for j, c in colours.items()}
    for coordinates, style in styles.items():
        entries[coordinates_in_words(coordinates, short=True)] = Line2D(
            [], [], **plain, **style, **_SOLVED
        )
    is_shown = "forward-difference" in dict(ways)
    if is_shown and times["published_reduction_percent"].notna().any():
        entries["published"] = Line2D([], [], **plain, **{**_COORDINATES[0], **_PUBLISHED})
    if not times["complete"].all():
        entries["branch breaks off"] = Line2D([], [], **plain, **_BREAK)
    figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=4)
    return figure


@_styled
def plot_sampling(table: pd.DataFrame) -> Figure:
    """Error of sampled forces against the exact ones over the number of samples, by case.

    Parameters
    ----------
    table
        As ``convergence.tabulate_sampling`` gives it.
    """
    cases = list(table.groupby(["case", "law"], sort=False))
    columns = max(1, min(2, len(cases)))
    rows = max(1, -(-len(cases) // columns))
    figure = Figure(figsize=(8, 0.6 + 2.8 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels[0, 0].set(xscale="log", yscale="log")
    for axes, ((case, law), of_case) in zip(panels.flat, cases, strict=False):
        levels = list(of_case.groupby("force_N"))
        for (force, of_level), colour in zip(levels, _level_colours(len(levels)), strict=True):
            look = {"color": colour, "linewidth": 1.1, "marker": "o", "markersize": 3.5}
            axes.loglog("samples", "error_relative", data=of_level, label=f"{force:g} N", **look)
        samples = np.unique(of_case["samples"])
        second_order = of_case["error_relative"].max() * (samples / samples[0]) ** -2.0
        look = {"color": "0.4", "linestyle": "--", "linewidth": 1.0, "zorder": 1}
        axes.plot(samples, second_order, label="second order", **look)
        axes.set_xticks(samples, samples)
        axes.minorticks_off()
        axes.set_title(f"{case}, {law} normal load")
        axes.legend(loc="lower left", ncols=2, fontsize=8, handlelength=1.5)
        axes.grid(True)
    for axes in panels.flat[max(1, len(cases)) :]:
        axes.set_axis_off()
    figure.supxlabel("samples a period", fontsize=9)
    figure.supylabel("relative error of the forces", fontsize=9)
    return figure


@_styled
def plot_models(models: pd.DataFrame) -> Figure:
    """Largest errors of the peaks of every model, beside its cost.

    Parameters
    ----------
    models
        As ``compare.tabulate_models`` gives it.
    """
    groups = list(models.groupby(["modes", "joint", "coordinates"], sort=False))
    groups.sort(key=lambda group: not is_enriched(group[0][0]))
    figure = Figure(figsize=(8, 1.1 + 0.2 * len(groups)), layout="constrained")
    errors, costs = figure.subplots(1, 2, sharey=True)
    columns = {"frequency": _REGIONS[0], "amplitude": _REGIONS[1]}
    for row, (_, some) in enumerate(groups):
        for what, colour in columns.items():
            error = some[f"peak_{what}_error_percent"].abs().max()
            marker = "o" if some["complete"].all() else "X"
            if error > 0:
                errors.plot(error, row, marker, color=colour, markersize=5)
        costs.plot(some["cpu_s"].sum(), row, "o", color="0.3", markersize=5)
    words = [
        f"{basis}, {joint_in_words(joint)}, {coordinates_in_words(coordinates, short=True)}"
        for (basis, joint, coordinates), _ in groups
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
    shown = [
        Line2D([], [], color=colour, marker="o", linestyle="none", label=what)
        for what, colour in columns.items()
    ]
    broken = {"color": "0.3", "marker": "X", "linestyle": "none"}
    if not models["complete"].all():
        shown.append(Line2D([], [], label="some branches broke off", **broken))
    figure.legend(handles=shown, loc="outside upper center", ncols=len(shown))
    return figure


@_styled
def plot_patterns(table: pd.DataFrame) -> Figure:
    """Errors of bases over their size: the largest over all patterns of sticking pairs.

    Parameters
    ----------
    table
        As ``convergence.tabulate_patterns`` gives it.
    """
    springs = {"x": "springs along the bar", "xz": "springs along the bar and across the contact"}
    figure = Figure(figsize=(8, 3.6), layout="constrained")
    panels = figure.subplots(1, len(springs), sharex=True, sharey=True)
    worst = table.groupby(["springs", "basis", "vectors", "resonance"], sort=False)[
        "error_percent"
    ].max()
    for axes, (name, words) in zip(panels, springs.items(), strict=True):
        _over_vectors(axes, worst[name].reset_index(), "error_percent", "resonance", "resonance {}")
        axes.set_title(words)
    _explain_bases(panels)
    figure.supylabel("largest error of a resonance (%)", fontsize=9)
    return figure


@_styled
def plot_bases(table: pd.DataFrame) -> Figure:
    """Errors of the peaks found in bases over their size, by force.

    Parameters
    ----------
    table
        As ``convergence.tabulate_basis_peaks`` gives it.
    """
    figure = Figure(figsize=(8, 3.8), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True)
    for axes, what in zip(panels, ("frequency", "amplitude"), strict=True):
        _over_vectors(axes, table, f"peak_{what}_error_percent", "force_N", "{:g} N")
        axes.set_ylabel(f"error of the peak's {what} (%)")
    _explain_bases(panels)
    return figure


@_styled
def plot_divisions(table: pd.DataFrame) -> Figure:
    """Largest errors of peaks over the number of regions, by the way to make them.

    Parameters
    ----------
    table
        As ``convergence.tabulate_divisions`` gives it.
    """
    figure = Figure(figsize=(8, 4.4), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True)
    ways = list(table.groupby(["division", "motion"], sort=False))
    for ((division, motion), of_way), colour in zip(ways, _REGIONS, strict=False):
        worst = of_way.drop(columns=["division", "motion"]).abs().groupby("regions").max()
        look = {"color": colour, "linewidth": 1.2, "markersize": 4}
        for axes, what in zip(panels, ("frequency", "amplitude"), strict=True):
            error = worst[f"peak_{what}_error_percent"]
            label = f"{division}, {motion}".replace("-", " ")
            axes.loglog(worst.index, error, marker="o", label=label, **look)
        look |= {"linestyle": ":", "marker": ".", "linewidth": 0.9}
        panels[0].loglog(worst.index, worst["region_error_percent"], zorder=1, **look)
    for axes, what in zip(panels, ("frequency", "amplitude"), strict=True):
        axes.set_xticks(table["regions"].unique(), table["regions"].unique())
        axes.minorticks_off()
        axes.set_xlabel("regions")
        axes.set_ylabel(f"largest error of a peak's {what} (%)")
        axes.grid(True)
    beforehand = Line2D([], [], color="0.3", linestyle=":", marker=".", linewidth=0.9)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        [*handles, beforehand],
        [*labels, "told before any response is solved"],
        loc="outside lower center",
        ncols=3,
    )
    return figure


def _over_vectors(axes: Axes, table: pd.DataFrame, error: str, level: str, label: str) -> None:
    """Size of an error over the vectors of a basis: a line for each level and kind of basis."""
    levels = table[level].unique()
    enriched = table["basis"].map(is_enriched)
    for value, colour in zip(levels, _level_colours(len(levels)), strict=True):
        for kind, style in zip((True, False), _COORDINATES, strict=False):
            some = table[(table[level] == value) & (enriched == kind)].sort_values("vectors")
            size = some[error].abs()
            look = {"color": colour, "linewidth": 1.1, "markersize": 4, **style}
            words = label.format(value) if kind else None
            # the largest basis has no error but by definition
            axes.loglog(some["vectors"][size > 0], size[size > 0], label=words, **look)
    ticks = sorted(table["vectors"].unique())
    axes.set_xticks(ticks, ticks)
    axes.minorticks_off()
    axes.set_xlabel("vectors of the basis")
    axes.grid(True)


def _explain_bases(panels: Sequence[Axes]) -> None:
    """A legend below: levels by their colour, kinds of basis by their line."""
    handles, labels = panels[0].get_legend_handles_labels()
    kinds = [Line2D([], [], color="0.3", markersize=4, **style) for style in _COORDINATES[:2]]
    panels[0].figure.legend(
        [*handles, *kinds],
        [*labels, "enriched", "free"],
        loc="outside lower center",
        ncols=min(len(handles) + 2, 6),
    )


@_styled
def plot_backbones(backbones: Mapping[str, xr.Dataset], forces: Sequence[float]) -> Figure:
    """Natural frequency and damping ratio over amplitude, by joint.

    Parameters
    ----------
    backbones
        ``backbone.nc`` by joint.
    forces
        Excitations [N] whose peaks are marked.
    """
    figure = Figure(figsize=(8, 6), layout="constrained")
    panels = figure.subplots(2, sharex=True)
    for (joint, backbone), colour in zip(
        backbones.items(), _level_colours(len(backbones)), strict=True
    ):
        amplitude = backbone["response_amplitude"].to_numpy() * _MM
        rising = np.argsort(backbone["peak_force"].to_numpy())
        force = backbone["peak_force"].to_numpy()[rising]
        reached = [each for each in forces if force.size and force[0] <= each <= force[-1]]
        shares = np.log(force), np.log(amplitude[rising])
        peaks = np.exp(np.interp(np.log(reached), *shares)) if reached else np.zeros(0)
        for axes, name, scale in zip(
            panels, ("natural_frequency", "damping_ratio"), (1.0, 100.0), strict=True
        ):
            values = backbone[name].to_numpy() * scale
            axes.plot(amplitude, values, color=colour, linewidth=1.3, label=joint_in_words(joint))
            if peaks.size:
                at_peaks = np.interp(np.log(peaks), np.log(amplitude), values)
                axes.plot(peaks, at_peaks, "o", color=colour, markersize=4)
    panels[0].set_ylabel("natural frequency (Hz)")
    panels[1].set_ylabel("damping ratio (%)")
    panels[1].set_yscale("log")
    _label_decades(panels[1])
    panels[1].set_xlabel("amplitude of the observed point (mm)")
    panels[0].legend()
    for axes in panels:
        axes.set_xscale("log")
        axes.grid(True)
    return figure


@dataclass(frozen=True)
class _Curve:
    """Response at one force level: frequency [Hz] and amplitude over force [mm/N], where solved.

    ``hidden`` are solutions that no slow sweep shows; ``peak`` is the index of the located peak,
    None where the branch shows none.
    """

    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    hidden: NDArray[np.bool_]
    peak: int | None
    broken_off: bool
    fell_back: bool

    @property
    def end(self) -> str:
        if self.frequency.size == 0:
            return "no solution found"
        return f"breaks off at {self.frequency[-1]:.1f} Hz"


def _curves(response: xr.Dataset) -> list[_Curve]:
    curves = []
    for level in range(response.sizes["force"]):
        at = response.isel(force=level)
        force = float(at["force_level"])
        mine = (response["excitation_force"] == force) & (response["converged"] == 1)
        solved = response.isel(solution=np.flatnonzero(mine))
        amplitude = solved["response_amplitude"].to_numpy() * _MM / force
        peak = np.flatnonzero(solved["response_amplitude"] == at["peak_amplitude"])
        curves.append(
            _Curve(
                frequency=solved["frequency"].to_numpy(),
                amplitude=amplitude,
                hidden=(solved["on_sweep_up"] + solved["on_sweep_down"]).to_numpy() == 0,
                peak=int(peak[0]) if peak.size else None,
                broken_off=not at["complete"],
                fell_back=bool(at["fell_back"]),
            )
        )
    return curves


def _or_beside(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether a place or one next to it is marked."""
    return np.convolve(mask, [1, 1, 1], "same") > 0


def _keep_in_view(axes: Axes, curves: Sequence[_Curve]) -> None:
    """Cut both axes to where some curve is near its peak, or breaks off."""
    curves = [curve for curve in curves if curve.frequency.size]
    if not curves:
        return
    near = np.concatenate([c.frequency[c.amplitude >= _FLANK * c.amplitude.max()] for c in curves])
    ends = [c.frequency[-1] for c in curves if c.broken_off]
    low, high = min([near.min(), *ends]), max([near.max(), *ends])
    margin = max(_MARGIN * (high - low), _LEAST_MARGIN * high)
    solved = np.concatenate([c.frequency for c in curves])
    if solved.min() < solved.max():
        low, high = max(low - margin, solved.min()), min(high + margin, solved.max())
    else:
        low, high = low - margin, high + margin
    axes.set_xlim(low, high)
    in_view = np.concatenate(
        [c.amplitude[(c.frequency >= low) & (c.frequency <= high)] for c in curves]
    )
    lowest = max(in_view.min() / 1.3, _DEPTH * min(c.amplitude.max() for c in curves))
    axes.set_ylim(lowest, in_view.max() * 1.5)


def _explain(
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
        [Line2D([], [], color=colour, linewidth=3) for colour in _level_colours(len(levels))],
        levels,
        title=quantity,
        loc="outside right upper",
        alignment="left",
    )


def _draw_section(
    axes: Axes,
    section: Mapping[int, Sequence[NDArray[np.int64]]],
    point: NDArray[np.float64],
    at_rest: NDArray[np.float64] | None = None,
) -> None:
    """Fill every part of a section, its points [m] where they are, over its outline at rest."""
    for part, loops in section.items():
        if at_rest is not None:
            rest = [at_rest[np.append(loop, loop[0])] * _MM for loop in loops]
            axes.add_collection(LineCollection(rest, colors="0.65", linewidths=0.6, zorder=1))
        # an outline of bolts would show where their shanks are cut to be tightened
        width = 0.5 if part < FIRST_BOLT else 0.0
        look = {"facecolors": _PARTS[min(part, 2)], "edgecolors": "0.15", "linewidths": width}
        _fill(axes, [_shape(point * _MM, loops)], **look, zorder=2)


def _draw_mesh(axes: Axes, assembly: xr.Dataset) -> None:
    """Draw the mesh from above at an angle, and mark the clamped nodes, force and response."""
    towards = np.array(_VIEW) / np.linalg.norm(_VIEW)
    right = np.array([-towards[1], towards[0], 0.0]) / np.hypot(*towards[:2])
    onto_paper = np.stack([right, np.cross(towards, right)], axis=-1)
    point = _positions(assembly, "coordinate", "node") * _MM
    drawn = point @ onto_paper
    for faces, part, light in _visible_faces(assembly, point, towards):
        colour = light * np.array(to_rgb(_PARTS[min(part, 2)]))
        thin = {"edgecolors": "0.2", "linewidths": 0.15}
        _fill(axes, [_shape(drawn, _outline(faces))], facecolors=colour, **thin)
        # bolts are too dark, and their elements too small, to show lines
        if part < FIRST_BOLT:
            lines = Shape.make_compound_path(*(Shape(drawn[line]) for line in _strokes(faces)))
            _fill(axes, [lines], facecolors="none", **thin)
    clamped = drawn[assembly["clamped_node"]]
    hull = clamped[ConvexHull(clamped).vertices]
    axes.add_patch(Polygon(hull, hatch="xxxxx", fill=False, linewidth=0.8))
    axes.text(clamped[:, 0].max(), clamped[:, 1].min(), "  clamped", va="top")
    excited, observed = (assembly[f"{name}_node"] for name in ("excitation", "response"))
    tip = drawn[int(excited)]
    tail = tip + _ARROW * onto_paper["xyz".index(excited.attrs["direction"])]
    arrow = {"arrowstyle": "-|>", "facecolor": "black", "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tip, tail, arrowprops=arrow)
    axes.text(*tail, f" excitation along {excited.attrs['direction']}", va="center")
    at = drawn[int(observed)]
    axes.plot(*at, "o", markersize=4, markerfacecolor="white", markeredgecolor="black", zorder=5)
    axes.text(*at, f"   response along {observed.attrs['direction']}", va="center")


def _visible_faces(
    assembly: xr.Dataset, point: NDArray[np.float64], towards: NDArray[np.float64]
) -> list[tuple[NDArray[np.int64], int, float]]:
    """Faces that a viewer above the assembly sees, in the order in which to paint them.

    Faces of a part that are lit alike come together: their nodes, shape (faces, 4), the part, and
    the light on them, between 0 and 1.
    """
    faces, part = _outer_faces(assembly)
    centre = point[faces].mean(axis=1)
    diagonals = point[faces[:, 2:]] - point[faces[:, :2]]
    normal = np.cross(diagonals[:, 0], diagonals[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # the bars fill a cuboid together, and hide what lies within it
    of_bars = centre[part < FIRST_BOLT]
    low, high = of_bars.min(axis=0) + _SAME, of_bars.max(axis=0) - _SAME
    within = np.all((centre > low) & (centre < high), axis=1)
    # from above, nuts are behind the bars and heads in front of them
    level = np.where(part < FIRST_BOLT, 0, np.sign(centre[:, 2])).astype(int)
    light = np.round(_TONES * (0.7 + 0.3 * normal @ _LIGHT)).astype(int)
    look = np.stack([level, part, light], axis=-1)
    seen = np.flatnonzero((normal @ towards > 0) & ~within)
    return [
        (faces[seen[(look[seen] == one).all(axis=1)]], int(one[1]), one[2] / _TONES)
        for one in np.unique(look[seen], axis=0)
    ]


def _draw_plan(axes: Axes, assembly: xr.Dataset) -> None:
    """Draw the contact surface with its holes, the bars around it, and lengths."""
    surface = _Surface.of(assembly)
    everything = surface.area_of(np.arange(len(surface.position)))
    x, y, _ = _bounds_of_bars(assembly)
    look = {"edgecolor": "0.15", "linewidth": 0.5}
    axes.add_patch(Rectangle((x[0], y[0]), np.ptp(x), np.ptp(y), facecolor="white", **look))
    axes.add_patch(PathPatch(everything, facecolor=_BLANK, **look))
    lap = everything.get_extents().intervalx
    bolts = assembly["bolt_position"].sel(axis="x").to_numpy() * _MM
    for begin, end in pairwise([lap[0], *bolts, lap[1]]):
        _dimension(axes, (begin, y[0] - _BESIDE), (end, y[0] - _BESIDE))
    _dimension(axes, (x[0] - _BESIDE, y[0]), (x[0] - _BESIDE, y[1]))
    # loops around holes run back
    hole = max(-_area(loop[:-1]) for loop in everything.to_polygons())
    axes.text(lap[1] + 3, 0, f"holes ⌀ {2 * np.sqrt(hole / np.pi):.4g}", va="center", fontsize=8)


def _draw_side(axes: Axes, assembly: xr.Dataset) -> None:
    """Draw the assembly cut along the middle of its width, and lengths."""
    point = _positions(assembly, "coordinate", "node")[:, [0, 2]]
    _draw_section(axes, _section(assembly, point), point)
    x, _, z = _bounds_of_bars(assembly)
    lap = assembly["position"].sel(axis="x").to_numpy() * _MM
    below = point[:, 1].min() * _MM - _BESIDE
    for begin, end in pairwise([x[0], lap.min(), lap.max(), x[1]]):
        _dimension(axes, (begin, below), (end, below))
    _dimension(axes, (x[0], below - 2 * _BESIDE), (x[1], below - 2 * _BESIDE))
    _dimension(axes, (x[0] - _BESIDE, z[0]), (x[0] - _BESIDE, z[1]))
    _dimension(axes, (x[1] + 2 * _BESIDE, 0.0), (x[1] + 2 * _BESIDE, z[1]))


def _dimension(axes: Axes, begin: tuple[float, float], end: tuple[float, float]) -> None:
    """Draw a dimension line, to the right or upwards, with its length."""
    points = np.array([begin, end])
    line = {"arrowstyle": "<|-|>,head_width=.12,head_length=.25", "linewidth": 0.5}
    line |= {"facecolor": "black", "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, begin, arrowprops=line)
    axes.update_datalim(points)  # texts do not widen the axes by themselves
    beside = {"ha": "center", "va": "top", "xytext": (0, -2)}
    if begin[0] == end[0]:
        beside = {"ha": "right", "va": "center", "xytext": (-3, 0)}
    length = f"{np.linalg.norm(points[1] - points[0]):.4g}"
    middle = points.mean(axis=0)
    axes.annotate(length, middle, textcoords="offset points", fontsize=8, **beside)


def _explain_parts(figure: Figure, at_rest: bool = False) -> None:
    handles = [Patch(facecolor=c, edgecolor="0.15", linewidth=0.5) for c in _PARTS]
    names = ["bar A", "bar B", "bolts"]
    if at_rest:
        handles.append(Line2D([], [], color="0.65", linewidth=0.9))
        names.append("at rest")
    figure.legend(handles, names, loc="outside upper center", ncols=len(names))


def _in_words(joint: str, coordinates: str) -> str:
    """Name of a method for people: ``6 regions of 7 elements, 1 RDNM``."""
    return f"{joint_in_words(joint)}, {coordinates_in_words(coordinates, short=True)}"


def _round_down(number: float) -> float:
    """The number cut to its first digit."""
    power = 10 ** np.floor(np.log10(number))
    return float(power * np.floor(number / power))


def _percent(share: float) -> str:
    """Share in whole percent; only nothing is 0 %, and only all is 100 %."""
    if 0 < share < 0.01:
        return "<1 %"
    return ">99 %" if 0.99 < share < 1 else f"{100 * share:.0f} %"


def _whole_loop(unloading: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacement or force round a whole loop; loading is unloading with both signs changed."""
    return np.concatenate([unloading, -unloading])


def _level_colours(count: int) -> NDArray[np.float64]:
    name, darkest, lightest = _LEVELS
    return matplotlib.colormaps[name](np.linspace(darkest, lightest, count))


def _part_of_map(name: str, low: float, high: float) -> Colormap:
    return ListedColormap(matplotlib.colormaps[name](np.linspace(low, high, 256)))


def _positions(dataset: xr.Dataset, name: str, along: str) -> NDArray[np.float64]:
    return dataset[name].transpose(along, "axis").to_numpy()


@dataclass(frozen=True)
class _Surface:
    """The contact surface in plan view, every quadrilateral cut into the shares of its corners.

    ``position`` (pairs, 3) [m]; ``facet`` (facets, 4) pairs; ``corner`` holds the points of the
    shares in mm, ``share`` (shares, 4) their corners and ``owner`` (shares,) their pairs.
    """

    position: NDArray[np.float64]
    facet: NDArray[np.int64]
    corner: NDArray[np.float64]
    share: NDArray[np.int64]
    owner: NDArray[np.int64]

    @classmethod
    def of(cls, assembly: xr.Dataset) -> "_Surface":
        position = _positions(assembly, "position", "pair")
        plan = position[:, :2] * _MM
        pair_of_node = np.full(assembly.sizes["node"], -1)
        pair_of_node[assembly["pair_node"].transpose("pair", "side")[:, 0]] = np.arange(len(plan))
        nodes, _ = _faces_among(assembly, pair_of_node >= 0)
        facet = _counter_clockwise(pair_of_node[nodes], plan)
        # middles of edges are numbered once for the two facets they belong to
        edge, of_facet = np.unique(np.sort(_edges(facet)), axis=0, return_inverse=True)
        middle = len(plan) + of_facet.reshape(-1, 4)
        centre = len(plan) + len(edge) + np.arange(len(facet))
        share = np.stack(
            [facet, middle, np.tile(centre[:, None], 4), np.roll(middle, 1, axis=1)], axis=-1
        )
        return cls(
            position=position,
            facet=facet,
            corner=np.concatenate([plan, plan[edge].mean(axis=1), plan[facet].mean(axis=1)]),
            share=share.reshape(-1, 4),
            owner=facet.ravel(),
        )

    def pairs_at(self, joint: xr.Dataset) -> NDArray[np.int64]:
        """The pair that each element of a joint sits on, shape (elements,)."""
        element = _positions(joint, "element_position", "element")
        distance, pair = KDTree(self.position).query(element)
        if distance.max() > _SAME:
            raise ValueError(f"{np.sum(distance > _SAME)} elements lie on no contact pair")
        return pair

    def area_of(self, pairs: Sequence[int] | NDArray[np.int64]) -> Shape:
        """What belongs to some pairs, as one shape."""
        return _shape(self.corner, _outline(self.share[np.isin(self.owner, pairs)]))

    def edges_along_middle(self) -> NDArray[np.int64]:
        """Pairs at both ends of the edges along the middle of the width, shape (edges, 2)."""
        y = self.position[:, 1]
        on_middle = np.abs(y - (y.min() + y.max()) / 2) < _SAME
        edges = _edges(self.facet)
        return np.unique(np.sort(edges[on_middle[edges].all(axis=1)]), axis=0)


def _section(
    assembly: xr.Dataset, side_view: NDArray[np.float64]
) -> dict[int, list[NDArray[np.int64]]]:
    """Outlines, as loops of nodes, of every part where the plane y = 0 cuts the assembly."""
    on_plane = np.abs(assembly["coordinate"].sel(axis="y").to_numpy()) < _SAME
    faces, part = _faces_among(assembly, on_plane)
    if len(faces) == 0:
        raise ValueError("the mesh has no faces in the plane y = 0")
    faces = _counter_clockwise(faces, side_view)
    return {int(p): _outline(faces[part == p]) for p in np.unique(part)}


def _faces_among(
    assembly: xr.Dataset, chosen: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces of the elements with all four corners among the chosen nodes, each once.

    Returns the nodes of the faces, shape (faces, 4), and their parts, shape (faces,).
    """
    faces, part = _faces(assembly)
    found = np.flatnonzero(chosen[faces].all(axis=1))
    _, first = np.unique(np.sort(faces[found]), axis=0, return_index=True)
    found = found[np.sort(first)]
    return faces[found], part[found]


def _outer_faces(assembly: xr.Dataset) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces that belong to one element only: nodes, shape (faces, 4), and part, shape (faces,)."""
    faces, part = _faces(assembly)
    _, first, count = np.unique(np.sort(faces), axis=0, return_index=True, return_counts=True)
    outer = first[count == 1]
    return faces[outer], part[outer]


def _label_decades(axes: Axes) -> None:
    """Plain numbers on the logarithmic vertical axis, also within decades where they are few."""
    low, high = axes.get_ylim()
    if high < _MANY_DECADES * low:
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())


def _faces(assembly: xr.Dataset) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces of all elements: nodes, shape (faces, 4), and part, shape (faces,)."""
    connectivity = assembly["connectivity"].transpose("element", "corner").to_numpy()
    faces = connectivity[:, HEXAHEDRON_FACES]
    return faces.reshape(-1, 4), np.repeat(assembly["part"].to_numpy(), faces.shape[1])


def _bounds_of_bars(assembly: xr.Dataset) -> NDArray[np.float64]:
    """Where both bars together begin and end [mm] along x, y and z, shape (3, 2)."""
    of_bars = assembly["connectivity"].to_numpy()[assembly["part"].to_numpy() < FIRST_BOLT]
    point = _positions(assembly, "coordinate", "node")[np.unique(of_bars)] * _MM
    return np.stack([point.min(axis=0), point.max(axis=0)], axis=-1)


def _counter_clockwise(polygon: NDArray[np.int64], point: NDArray[np.float64]) -> NDArray[np.int64]:
    """Polygons, shape (polygons, corners), turned so that all run the same way round."""
    return np.where(_area(point[polygon])[:, None] < 0, polygon[:, ::-1], polygon)


def _area(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area of polygons from their corners, shape (..., corners, 2); negative for clockwise ones."""
    x, y = np.moveaxis(corner, -1, 0)
    return (x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1)).sum(axis=-1) / 2


def _edges(polygon: NDArray[np.int64]) -> NDArray[np.int64]:
    """Both ends of all edges of polygons, one polygon after another, shape (edges, 2)."""
    return np.stack([polygon, np.roll(polygon, -1, axis=1)], axis=-1).reshape(-1, 2)


def _outline(polygon: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Outline of polygons that share corners, as loops of points; loops around holes run back."""
    edges = _edges(polygon).tolist()
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


def _strokes(polygon: NDArray[np.int64]) -> list[list[int]]:
    """Edges of polygons, each once, in lines as long as can be: few points to write down."""
    neighbours = defaultdict(set)
    for begin, end in _edges(polygon).tolist():
        neighbours[begin].add(end)
        neighbours[end].add(begin)
    lines = []
    for begin in sorted(neighbours):
        while neighbours[begin]:
            line = [begin]
            while neighbours[line[-1]]:
                last, following = line[-1], min(neighbours[line[-1]])
                neighbours[last].remove(following)
                neighbours[following].remove(last)
                line.append(following)
            lines.append(line)
    return lines


def _shape(point: NDArray[np.float64], loops: Iterable[NDArray[np.int64]]) -> Shape:
    """One shape from several loops of points; it may be empty."""
    closed = [Shape(point[np.append(loop, loop[0])], closed=True) for loop in loops]
    return Shape.make_compound_path(*closed)


def _fill(axes: Axes, shapes: Sequence[Shape], **look: object) -> None:
    axes.add_collection(PathCollection(shapes, **{"linewidths": 0, **look}))


def _profile(axes: Axes, surface: "_Surface", value: NDArray[np.float64]) -> None:
    """Draw what the pairs along the middle of the width have, open ones hollow at zero."""
    edges = surface.edges_along_middle()
    x = surface.position[:, 0] * _MM
    lines = [np.c_[x[edge], value[edge]] for edge in edges]
    axes.add_collection(LineCollection(lines, colors="0.6", linewidths=0.9))
    loaded = value > 0
    for state, colour, label in ((loaded, "black", "loaded"), (~loaded, "white", "open")):
        pairs = np.intersect1d(edges, np.flatnonzero(state))
        look = {"markersize": 3.5, "color": colour, "markeredgecolor": "black"}
        axes.plot(x[pairs], value[pairs], "o", **look, markeredgewidth=0.6, label=label)
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1), borderpad=0, ncols=2)
    axes.grid(True)


def _divide_profile(
    axes: Axes, surface: "_Surface", value: NDArray[np.float64], cuts: NDArray[np.float64]
) -> None:
    """Colour the parts of regions under the profile, which runs straight across the holes."""
    pairs = np.unique(surface.edges_along_middle())
    pairs = pairs[np.argsort(surface.position[pairs, 0])]
    x = surface.position[pairs, 0] * _MM
    ends = np.concatenate([x[:1], cuts, x[-1:]])
    for number, (begin, end) in enumerate(pairwise(ends)):
        part = np.unique(np.clip(x, begin, end))
        colour = _REGIONS[number % len(_REGIONS)]
        height = np.interp(part, x, value[pairs])
        axes.fill_between(part, height, color=colour, alpha=0.45, linewidth=0)


def _plan_view(axes: Axes, surface: _Surface) -> None:
    x, y = (surface.position[:, :2] * _MM).T
    axes.set_aspect("equal")
    axes.set_xlim(x.min() - 1, x.max() + 1)
    axes.set_ylim(y.min() - 1, y.max() + 1)
    axes.set_yticks([y.min(), (y.min() + y.max()) / 2, y.max()])
    axes.set_ylabel("y (mm)")
