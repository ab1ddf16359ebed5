"""What do the results look like? One function a figure, from datasets to a matplotlib figure.

One language throughout: colour tells the level of force or displacement, from dark for the lowest
to light for the highest; a thin line is the reference, a broad pale line the model that stands in
for it; a dot is a peak, a cross the place where a path broke off.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path as Shape
from numpy.typing import NDArray
from scipy.spatial import KDTree

from boltjoint.names import parse_coordinates, parse_joint
from boltjoint.structure.mesh import HEXAHEDRON_FACES

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

#: levels of force or displacement; ends before the yellow that white paper swallows
_LEVELS = ("plasma", 0.0, 0.85)

_REFERENCE = {"linewidth": 1.1, "zorder": 3}
_MODEL = {"linewidth": 4.0, "alpha": 0.45, "zorder": 2}
_PEAK = {"marker": "o", "markeredgecolor": "white", "markeredgewidth": 0.6, "linestyle": "none"}
_BREAK = {"marker": "X", "markeredgecolor": "black", "markeredgewidth": 0.7, "linestyle": "none"}

#: bar A, bar B, bolts
_PARTS = ("#b9cfe4", "#e6d3b3", "#4d4d4d")
#: neighbouring regions differ; they are numbered, so colours may come again
_REGIONS = ("#4477aa", "#ee9944", "#228833", "#cc6677", "#66ccee", "#997700")
_BLANK = "0.87"

#: largest displacement of a drawn mode over the length of the assembly
_DEFLECTION = 0.06
#: response over its peak down to which a curve is kept in view
_FLANK = 1 / 2
#: what is shown on both sides of that, over its width and at least over the frequency
_MARGIN, _LEAST_MARGIN = 0.25, 0.02
#: response over the lowest peak down to which antiresonances are followed
_DEPTH = 1 / 30
#: points closer than this [m] are one
_SAME = 1e-9

_MM, _UM = 1e3, 1e6

_styled = matplotlib.rc_context(STYLE)


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure as SVG, the same bytes for the same content; its folder is made."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(STYLE):
        figure.savefig(path, format="svg", bbox_inches="tight", metadata={"Date": None})


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
        for part, loops in section.items():
            rest = [at_rest[np.append(loop, loop[0])] * _MM for loop in loops]
            axes.add_collection(LineCollection(rest, colors="0.65", linewidths=0.6, zorder=1))
            look = {"facecolors": _PARTS[min(part, 2)], "edgecolors": "0.15", "linewidths": 0.5}
            _fill(axes, [_shape(moved * _MM, loops)], **look, zorder=2)
        axes.set_title(f"mode {index + 1}: {modes['natural_frequency'].values[index]:.1f} Hz")
        axes.set_aspect("equal")
        beyond = _DEFLECTION * length * _MM
        axes.set_xlim(left * _MM - beyond / 2, (left + length) * _MM + beyond)
        axes.set_ylim(-height / 2 * _MM - beyond, height / 2 * _MM + beyond)
    figure.supxlabel("x (mm)", fontsize=9)
    figure.supylabel("z (mm), displacements enlarged", fontsize=9)
    figure.legend(
        [
            *(Patch(facecolor=c, edgecolor="0.15", linewidth=0.5) for c in _PARTS),
            Line2D([], [], color="0.65", linewidth=0.9),
        ],
        ["bar A", "bar B", "bolts", "at rest"],
        loc="outside upper center",
        ncols=4,
    )
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
    edges = surface.edges_along_middle()
    x = surface.position[:, 0] * _MM
    axes.add_collection(
        LineCollection([np.c_[x[edge], load[edge]] for edge in edges], colors="0.6", linewidths=0.9)
    )
    for state, colour, label in ((loaded, "black", "loaded"), (~loaded, "white", "open")):
        pairs = np.intersect1d(edges, np.flatnonzero(state))
        look = {"markersize": 3.5, "color": colour, "markeredgecolor": "black"}
        axes.plot(x[pairs], load[pairs], "o", **look, markeredgewidth=0.6, label=label)
    axes.set(xlabel="x (mm)", ylabel="normal load (N)")
    axes.set_title("pairs along the middle of the width", loc="left")
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1), borderpad=0, ncols=2)
    axes.grid(True)
    return figure


@_styled
def plot_regions(assembly: xr.Dataset, joint: xr.Dataset) -> Figure:
    """Where the regions of a joint lie, with the number of elements and the share of load of each.

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
    distance, pair = KDTree(surface.position).query(
        _positions(joint, "element_position", "element")
    )
    if distance.max() > _SAME:
        raise ValueError(f"{np.sum(distance > _SAME)} elements lie on no contact pair")
    region = joint["point_of_element"].to_numpy()
    # friction is the same everywhere, so slip forces stand to each other as normal loads do
    slip_force = joint["slip_force"].to_numpy()
    count = np.bincount(region)
    share = 100 * np.bincount(region, slip_force) / slip_force.sum()
    figure = Figure(figsize=(8, 4.2), layout="compressed")
    plan, bars = figure.subplots(2, 1, sharex=True)
    without = np.setdiff1d(np.arange(len(surface.position)), pair)
    _fill(plan, [surface.area_of(without)], facecolors=_BLANK)
    areas = [surface.area_of(pair[region == number]) for number in range(count.size)]
    middle = [area.get_extents().intervalx.mean() for area in areas]
    width = 0.8 * np.diff(np.sort(middle)).min(initial=np.ptp(surface.corner[:, 0]))
    many = count.size > 10
    for number, (x, elements, percent) in enumerate(zip(middle, count, share, strict=True)):
        look = {"color": _REGIONS[number % len(_REGIONS)], "linewidth": 0}
        _fill(plan, [areas[number]], **look)
        above = {"ha": "center", "va": "bottom"}
        plan.text(x, surface.corner[:, 1].max() + 1, number + 1, weight="bold", **above)
        bars.bar(x, percent, width, **look)
        text = f" {elements}, {percent:.1f} %" if many else f"{elements}\n{percent:.1f} %"
        bars.text(x, percent, text, rotation=90 if many else 0, **above)
    _plan_view(plan, surface)
    bars.set(xlabel="x (mm)", ylabel="share of the\nnormal load (%)")
    bars.set_ylim(0, share.max() * (1.9 if many else 1.5))
    bars.set_title("number of elements and share of the normal load of each region")
    return figure


@_styled
def plot_loops(reduced: xr.Dataset, regions: xr.Dataset, region: int = 1) -> Figure:
    """Hysteresis loops of a region: all its elements against the few fitted to them.

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
        np.sum(joint["point_of_element"].to_numpy() == region - 1) for joint in (reduced, regions)
    )
    here = reduced.isel(point=region - 1).transpose(..., "loop", "sample")
    amplitude = here["loop_amplitude"].to_numpy() * _UM
    figure = Figure(figsize=(8, 4.8), layout="constrained")
    axes = figure.subplots()
    all_of_them, fitted = f"region {region}, all its {many} elements", f"the {few} fitted to them"
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

    Shown are the frequencies around those at which some response is half its peak or more.

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
            axes.semilogy(x, y, color=colour, label=f"{name}, {forces[index]:g} N", **style)
            if curve.peak is not None:
                at = [curve.peak]
                axes.plot(x[at], y[at], color=colour, markersize=7 * size, zorder=4, **_PEAK)
            if curve.broken_off:
                axes.plot(x[-1:], y[-1:], color=colour, markersize=9 * size, zorder=5, **_BREAK)
                marks["path breaks off"] = _BREAK
                levels[index] += f"\n{'reference ' if solved is reference else ''}{curve.end}"
        shown += curves
    _keep_in_view(axes, shown)
    axes.set(xlabel="frequency (Hz)", ylabel="response / force (mm/N)")
    axes.grid(True)
    _explain(axes, {name: style for name, (_, style) in layers.items()}, "force", levels, marks)
    return figure


@dataclass(frozen=True)
class _Curve:
    """Response at one force level: frequency [Hz] and amplitude over force [mm/N], where solved.

    ``peak`` is the index of the located peak, None where the path shows none.
    """

    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    peak: int | None
    broken_off: bool

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
                peak=int(peak[0]) if peak.size else None,
                broken_off=not at["complete"],
            )
        )
    return curves


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
    low, high = max(low - margin, solved.min()), min(high + margin, solved.max())
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


def _in_words(joint: str, coordinates: str) -> str:
    """Name of a method for people: ``6 regions of 7 elements, 1 RDNM``."""
    regions, elements = parse_joint(joint)
    if regions is None:
        name = "node-to-node"
    else:
        name = f"{regions} regions" + (f" of {elements} elements" if elements else "")
    number = parse_coordinates(coordinates)
    return f"{name}, linear modes" if number is None else f"{name}, {number} RDNM"


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
        edges = np.stack([facet, np.roll(facet, -1, axis=1)], axis=-1)
        edge, of_facet = np.unique(np.sort(edges).reshape(-1, 2), axis=0, return_inverse=True)
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

    def area_of(self, pairs: Sequence[int] | NDArray[np.int64]) -> Shape:
        """What belongs to some pairs, as one shape."""
        return _shape(self.corner, _outline(self.share[np.isin(self.owner, pairs)]))

    def edges_along_middle(self) -> NDArray[np.int64]:
        """Pairs at both ends of the edges along the middle of the width, shape (edges, 2)."""
        y = self.position[:, 1]
        on_middle = np.abs(y - (y.min() + y.max()) / 2) < _SAME
        edges = np.stack([self.facet, np.roll(self.facet, -1, axis=1)], axis=-1).reshape(-1, 2)
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
    connectivity = assembly["connectivity"].transpose("element", "corner").to_numpy()
    faces = connectivity[:, HEXAHEDRON_FACES].reshape(-1, 4)
    found = np.flatnonzero(chosen[faces].all(axis=1))
    _, first = np.unique(np.sort(faces[found]), axis=0, return_index=True)
    found = found[np.sort(first)]
    return faces[found], assembly["part"].to_numpy()[found // len(HEXAHEDRON_FACES)]


def _counter_clockwise(polygon: NDArray[np.int64], point: NDArray[np.float64]) -> NDArray[np.int64]:
    """Polygons, shape (polygons, corners), turned so that all run the same way round."""
    x, y = np.moveaxis(point[polygon], -1, 0)
    area = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    return np.where(area[:, None] < 0, polygon[:, ::-1], polygon)


def _outline(polygon: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Outline of polygons that share corners, as loops of points; loops around holes run back."""
    edges = np.stack([polygon, np.roll(polygon, -1, axis=1)], axis=-1).reshape(-1, 2).tolist()
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


def _shape(point: NDArray[np.float64], loops: Iterable[NDArray[np.int64]]) -> Shape:
    """One shape from several loops of points; it may be empty."""
    closed = [Shape(point[np.append(loop, loop[0])], closed=True) for loop in loops]
    return Shape.make_compound_path(*closed)


def _fill(axes: Axes, shapes: Sequence[Shape], **look: object) -> None:
    axes.add_collection(PathCollection(shapes, **{"linewidths": 0, **look}))


def _plan_view(axes: Axes, surface: _Surface) -> None:
    x, y = (surface.position[:, :2] * _MM).T
    axes.set_aspect("equal")
    axes.set_xlim(x.min() - 1, x.max() + 1)
    axes.set_ylim(y.min() - 1, y.max() + 1)
    axes.set_yticks([y.min(), (y.min() + y.max()) / 2, y.max()])
    axes.set_ylabel("y (mm)")
