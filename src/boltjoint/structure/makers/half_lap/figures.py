"""Figures of half laps: mesh, modes, initial gap, and deformation under preload."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Polygon, Rectangle
from matplotlib.path import Path as Shape
from numpy.typing import NDArray

from boltjoint.joint.surface_places import SAME_POINT
from boltjoint.report.figures.contact import set_plan_view
from boltjoint.report.figures.outlines import (
    ContactSurface,
    closed_shape,
    long_lines,
    outer_faces,
    outline_loops,
    polygon_area,
    positions_of,
    section_outlines,
)
from boltjoint.report.figures.style import BLANK_COLOUR, MM, UM, figure_style, fill_shapes
from boltjoint.structure.makers.half_lap.parts import FIRST_BOLT, part_kinds

#: of bar A, bar B, bolts and washers
PART_COLOURS = {"bar A": "#b9cfe4", "bar B": "#e6d3b3", "bolts": "#4d4d4d", "washers": "#9c8f80"}
#: largest displacement of a drawn mode over the length of the assembly
_DEFLECTION = 0.06
#: largest displacement drawn under preload, that of a cut shank's end, over the height
_OVERLAP = 0.4
#: direction from the assembly to the viewer of the mesh, who must be above it
_VIEW = (-0.35, -1.0, 0.65)
#: direction to the light, and number of tones
_LIGHT, _TONES = np.array([-0.3, -0.5, 0.81]), 16
#: length of the arrows at force and response, and distance of dimension lines [mm]
_ARROW, _BESIDE = 25.0, 7.0


@figure_style
def plot_mesh(assembly: xr.Dataset) -> Figure:
    """Mesh of an assembly with its clamp and points, and the main dimensions of the bars.

    The mesh is seen from above at an angle, without what is hidden; below it are the contact
    surface from above and the assembly from the side, cut along the middle of its width.

    Parameters
    ----------
    assembly
        As ``build_assembly`` returns it.

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
    _add_legend_of_parts(figure, assembly)
    return figure


@figure_style
def plot_modes(assembly: xr.Dataset, modes: xr.Dataset) -> Figure:
    """Mode shapes of an assembly seen from the side, cut along the middle of its width.

    Those in which this plane moves across itself are seen from above, cut along the contact.

    Parameters
    ----------
    assembly
        As ``build_assembly`` returns it.
    modes
        As ``find_modes`` returns them, of that assembly.

    Raises
    ------
    ValueError
        If the mesh has no faces in the plane y = 0.
    """
    coordinate = assembly["coordinate"].transpose("node", "axis").to_numpy()
    shape = modes["mode_shape"].transpose("mode", "node", "axis").to_numpy()
    at_rest = coordinate[:, [0, 2]]
    section = section_outlines(assembly, at_rest)
    middle = np.unique(np.concatenate([loop for loops in section.values() for loop in loops]))
    largest = np.abs(shape[:, middle]).max(axis=1)
    from_above = largest[:, 1] > np.maximum(largest[:, 0], largest[:, 2])
    plan = section_outlines(assembly, coordinate[:, :2], "z") if from_above.any() else {}
    (length, height), left = np.ptp(at_rest, axis=0), at_rest[:, 0].min()
    columns = 1 if len(shape) <= 5 else 2
    rows = -(-len(shape) // columns)
    figure = Figure(figsize=(8, 0.7 + 1.75 * rows / columns), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes in panels.flat[len(shape) :]:
        axes.set_axis_off()
    for index, displacement in enumerate(shape):
        axes = panels.flat[index]
        cut, view, note = section, [0, 2], ""
        if from_above[index]:
            cut, view, note = plan, [0, 1], ", from above"
        seen, displacement = coordinate[:, view], displacement[:, view]
        moved = seen + _DEFLECTION * length * displacement / np.abs(displacement).max()
        _draw_section(axes, assembly, cut, moved, seen)
        frequency = modes["natural_frequency"][index].item()
        axes.set_title(f"mode {index + 1}: {frequency:.1f} Hz{note}")
        axes.set_aspect("equal")
        beyond = _DEFLECTION * length * MM
        axes.set_xlim(left * MM - beyond / 2, (left + length) * MM + beyond)
        axes.set_ylim(-height / 2 * MM - beyond, height / 2 * MM + beyond)
    figure.supxlabel("x (mm)", fontsize=9)
    height_or_width = "z, or from above y (mm)" if from_above.any() else "z (mm)"
    figure.supylabel(f"{height_or_width}, displacements enlarged", fontsize=9)
    _add_legend_of_parts(figure, assembly, at_rest=True)
    return figure


@figure_style
def plot_deformation(assembly: xr.Dataset, preload: xr.Dataset) -> Figure:
    """Assembly with tight bolts seen from the side, cut along the middle, displacements enlarged.

    The overlap at the cut through every shank is the shortening by which the bolt is tightened.

    Parameters
    ----------
    assembly
        As ``build_assembly`` returns it.
    preload
        As ``apply_preload`` returns it, of that assembly.

    Raises
    ------
    ValueError
        If the two do not hold the same nodes, or the mesh has no faces in the plane y = 0.
    """
    if assembly.sizes["node"] != preload.sizes["node"]:
        raise ValueError("assembly and preload hold different nodes")
    at_rest = positions_of(assembly, "coordinate", "node")[:, [0, 2]]
    displacement = positions_of(preload, "displacement", "node")[:, [0, 2]]
    section = section_outlines(assembly, at_rest)
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
        _draw_section(axes, assembly, section, moved, at_rest)
        axes.set_aspect("equal")
        axes.set_xlim(low * MM, high * MM)
        axes.set_ylim(1.25 * at_rest[:, 1].min() * MM, 1.25 * at_rest[:, 1].max() * MM)
        axes.set_title(f"{name}, displacements × {scale:g}", loc="left")
        axes.set_ylabel("z (mm)")
    panels[-1].set_xlabel("x (mm)")
    _add_legend_of_parts(figure, assembly, at_rest=True)
    return figure


def _draw_section(
    axes: Axes,
    assembly: xr.Dataset,
    section: Mapping[int, Sequence[NDArray[np.int64]]],
    point: NDArray[np.float64],
    at_rest: NDArray[np.float64] | None = None,
) -> None:
    """Fill every part of a section with its points [m] displaced, over its outline at rest."""
    kinds = part_kinds(assembly)
    for part, loops in section.items():
        if at_rest is not None:
            rest = [at_rest[np.append(loop, loop[0])] * MM for loop in loops]
            axes.add_collection(LineCollection(rest, colors="0.65", linewidths=0.6, zorder=1))
        # an outline of bolts would show the cuts through their shanks
        width = 0.0 if kinds[part] == "bolts" else 0.5
        style = {"facecolors": PART_COLOURS[kinds[part]], "linewidths": width, "zorder": 2}
        fill_shapes(axes, [closed_shape(point * MM, loops)], edgecolors="0.15", **style)


def _draw_mesh(axes: Axes, assembly: xr.Dataset) -> None:
    """Draw the mesh from above at an angle, and mark the clamped nodes, force and response."""
    towards = np.array(_VIEW) / np.linalg.norm(_VIEW)
    right = np.array([-towards[1], towards[0], 0.0]) / np.hypot(*towards[:2])
    onto_paper = np.stack([right, np.cross(towards, right)], axis=-1)
    point = positions_of(assembly, "coordinate", "node") * MM
    drawn = point @ onto_paper
    for faces, kind, light in _visible_faces(assembly, point, towards):
        colour = light * np.array(to_rgb(PART_COLOURS[kind]))
        thin = {"edgecolors": "0.2", "linewidths": 0.15}
        fill_shapes(axes, [closed_shape(drawn, outline_loops(faces))], facecolors=colour, **thin)
        # bolts are too dark, and their elements as those of washers too small, to show lines
        if kind not in ("bolts", "washers"):
            lines = Shape.make_compound_path(*(Shape(drawn[line]) for line in long_lines(faces)))
            fill_shapes(axes, [lines], facecolors="none", **thin)
    from scipy.spatial import ConvexHull  # takes long to import

    clamped = drawn[assembly["clamped_node"]]
    if clamped.size:
        hull = clamped[ConvexHull(clamped).vertices]
        axes.add_patch(Polygon(hull, hatch="xxxxx", fill=False, linewidth=0.8))
        axes.text(clamped[:, 0].max(), clamped[:, 1].min(), "  clamped", va="top")
    excited, observed = (assembly[f"{name}_node"] for name in ("excitation", "response"))
    tip = drawn[int(excited)]
    tail = tip + _ARROW * onto_paper["xyz".index(excited.attrs["direction"])]
    arrow = {"arrowstyle": "-|>", "facecolor": "black", "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tip, tail, arrowprops=arrow)
    axes.text(tail[0], tail[1], f" excitation along {excited.attrs['direction']}", va="center")
    at = drawn[int(observed)]
    axes.plot(*at, "o", markersize=4, markerfacecolor="white", markeredgecolor="black", zorder=5)
    axes.text(at[0], at[1], f"   response along {observed.attrs['direction']}", va="center")


def _visible_faces(
    assembly: xr.Dataset, point: NDArray[np.float64], towards: NDArray[np.float64]
) -> list[tuple[NDArray[np.int64], str, float]]:
    """Faces that a viewer above the assembly sees, in the order in which to paint them.

    Faces of a part with the same tone are one group: their nodes, shape (faces, 4), the kind of the
    part, and the light on them, between 0 and 1.
    """
    faces, part = outer_faces(assembly)
    centre = point[faces].mean(axis=1)
    diagonals = point[faces[:, 2:]] - point[faces[:, :2]]
    normal = np.cross(diagonals[:, 0], diagonals[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # the bars fill a cuboid together, and hide what lies within it
    of_bars = centre[part < FIRST_BOLT]
    low, high = of_bars.min(axis=0) + SAME_POINT, of_bars.max(axis=0) - SAME_POINT
    within = np.all((centre > low) & (centre < high), axis=1)
    # seen from above, nuts are below the bars and heads above them, with washers between
    kinds = part_kinds(assembly)
    beyond = np.array([{"bolts": 2, "washers": 1}.get(kind, 0) for kind in kinds])[part]
    level = (beyond * np.sign(centre[:, 2])).astype(int)
    light = np.round(_TONES * (0.7 + 0.3 * normal @ _LIGHT)).astype(int)
    style = np.stack([level, part, light], axis=-1)
    seen = np.flatnonzero((normal @ towards > 0) & ~within)
    return [
        (faces[seen[(style[seen] == one).all(axis=1)]], kinds[one[1]], one[2] / _TONES)
        for one in np.unique(style[seen], axis=0)
    ]


def _draw_plan(axes: Axes, assembly: xr.Dataset) -> None:
    """Draw the contact surface with its holes, the bars around it, and lengths."""
    surface = ContactSurface.of(assembly)
    everything = surface.area_of(np.arange(len(surface.position)))
    x, y, _ = _bounds_of_bars(assembly)
    style: dict[str, Any] = {"edgecolor": "0.15", "linewidth": 0.5}
    axes.add_patch(Rectangle((x[0], y[0]), np.ptp(x), np.ptp(y), facecolor="white", **style))
    axes.add_patch(PathPatch(everything, facecolor=BLANK_COLOUR, **style))
    lap = everything.get_extents().intervalx
    bolts = assembly["bolt_position"].sel(axis="x").to_numpy() * MM
    for begin, end in pairwise([lap[0], *bolts, lap[1]]):
        _draw_dimension(axes, (begin, y[0] - _BESIDE), (end, y[0] - _BESIDE))
    _draw_dimension(axes, (x[0] - _BESIDE, y[0]), (x[0] - _BESIDE, y[1]))
    # loops around holes run back
    hole = max(-polygon_area(np.asarray(loop)[:-1]) for loop in everything.to_polygons())
    axes.text(lap[1] + 3, 0, f"holes ⌀ {2 * np.sqrt(hole / np.pi):.4g}", va="center", fontsize=8)


def _draw_side(axes: Axes, assembly: xr.Dataset) -> None:
    """Draw the assembly cut along the middle of its width, and lengths."""
    point = positions_of(assembly, "coordinate", "node")[:, [0, 2]]
    _draw_section(axes, assembly, section_outlines(assembly, point), point)
    x, _, z = _bounds_of_bars(assembly)
    lap = assembly["position"].sel(axis="x").to_numpy() * MM
    below = point[:, 1].min() * MM - _BESIDE
    for begin, end in pairwise([x[0], lap.min(), lap.max(), x[1]]):
        _draw_dimension(axes, (begin, below), (end, below))
    _draw_dimension(axes, (x[0], below - 2 * _BESIDE), (x[1], below - 2 * _BESIDE))
    _draw_dimension(axes, (x[0] - _BESIDE, z[0]), (x[0] - _BESIDE, z[1]))
    _draw_dimension(axes, (x[1] + 2 * _BESIDE, 0.0), (x[1] + 2 * _BESIDE, z[1]))


def _bounds_of_bars(assembly: xr.Dataset) -> NDArray[np.float64]:
    """Ends [mm] of both bars together along x, y and z, shape (3, 2)."""
    of_bars = assembly["connectivity"].to_numpy()[assembly["part"].to_numpy() < FIRST_BOLT]
    point = positions_of(assembly, "coordinate", "node")[np.unique(of_bars)] * MM
    return np.stack([point.min(axis=0), point.max(axis=0)], axis=-1)


def _draw_dimension(axes: Axes, begin: tuple[float, float], end: tuple[float, float]) -> None:
    """Draw a dimension line, to the right or upwards, with its length."""
    points = np.array([begin, end])
    line = {"arrowstyle": "<|-|>,head_width=.12,head_length=.25", "linewidth": 0.5}
    line |= {"facecolor": "black", "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, begin, arrowprops=line)
    axes.update_datalim(points)  # texts do not widen the axes by themselves
    beside: dict[str, Any] = {"ha": "center", "va": "top", "xytext": (0, -2)}
    if begin[0] == end[0]:
        beside = {"ha": "right", "va": "center", "xytext": (-3, 0)}
    length = f"{np.linalg.norm(points[1] - points[0]):.4g}"
    middle = points.mean(axis=0)
    axes.annotate(length, middle, textcoords="offset points", fontsize=8, **beside)


def _add_legend_of_parts(figure: Figure, assembly: xr.Dataset, at_rest: bool = False) -> None:
    names = list(dict.fromkeys(part_kinds(assembly)))
    colours = [PART_COLOURS[name] for name in names]
    handles: list[Patch | Line2D] = [
        Patch(facecolor=c, edgecolor="0.15", linewidth=0.5) for c in colours
    ]
    if at_rest:
        handles.append(Line2D([], [], color="0.65", linewidth=0.9))
        names.append("at rest")
    figure.legend(handles, names, loc="outside upper center", ncols=len(names))


def _round_down(number: float) -> float:
    """The number cut to its first digit."""
    power = 10 ** np.floor(np.log10(number))
    return float(power * np.floor(number / power))


@figure_style
def plot_initial_gap(assembly: xr.Dataset) -> Figure:
    """Initial gap over the contact, and along the middle and the edges of its width.

    Parameters
    ----------
    assembly
        As ``build_assembly`` returns it, of surfaces with a form error.

    Raises
    ------
    ValueError
        If the assembly has no initial gap.
    """
    if "initial_gap" not in assembly:
        raise ValueError("assembly has no initial gap: its surfaces are flat")
    surface = ContactSurface.of(assembly)
    gap = assembly["initial_gap"].to_numpy() * UM
    figure = Figure(figsize=(8, 4.2), layout="compressed")
    plan, profile = figure.subplots(2, 1, sharex=True, height_ratios=[1, 1.2])
    colours = ListedColormap(matplotlib.colormaps["GnBu"](np.linspace(0.08, 1.0, 256)))
    norm = Normalize(0, gap.max() or 1)
    cells = [surface.area_of([pair]) for pair in range(gap.size)]
    fill_shapes(plan, cells, facecolors=colours(norm(gap)), edgecolors="face", linewidths=0.2)
    figure.colorbar(
        ScalarMappable(norm, colours), ax=plan, label="initial gap (μm)", pad=0.01, aspect=8
    )
    set_plan_view(plan, surface)
    x, y = (surface.place * MM).T
    edges = surface.edges_along_middle()
    lines = [np.c_[x[edge], gap[edge]] for edge in edges]
    # a hole interrupts the middle
    profile.add_collection(LineCollection(lines, colors="black", label="middle of the width"))
    on_edge = np.flatnonzero(np.isclose(y, y.max()))
    profile.plot(x[on_edge], gap[on_edge], color="black", linestyle="--", label="edge of the width")
    profile.set(xlabel="x (mm)", ylabel="initial gap (μm)")
    profile.set_ylim(bottom=0)
    profile.legend(loc="lower right", bbox_to_anchor=(1, 1), borderpad=0, ncols=2)
    profile.grid(True)
    return figure
