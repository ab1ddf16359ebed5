"""Figures of the assembly: mesh, modes, deformation."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from boltjoint.report.figures.drawing import draw_mesh, draw_plan, draw_section, draw_side
from boltjoint.report.figures.style import MM, PART_COLOURS, positions_of, section_outlines, styled

#: largest displacement of a drawn mode over the length of the assembly
_DEFLECTION = 0.06


#: largest displacement drawn under preload, that of a cut shank's end, over the height
_OVERLAP = 0.4


@styled
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
    section = section_outlines(assembly, at_rest)
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
        draw_section(axes, section, moved, at_rest)
        axes.set_title(f"mode {index + 1}: {modes['natural_frequency'][index].item():.1f} Hz")
        axes.set_aspect("equal")
        beyond = _DEFLECTION * length * MM
        axes.set_xlim(left * MM - beyond / 2, (left + length) * MM + beyond)
        axes.set_ylim(-height / 2 * MM - beyond, height / 2 * MM + beyond)
    figure.supxlabel("x (mm)", fontsize=9)
    figure.supylabel("z (mm), displacements enlarged", fontsize=9)
    _explain_parts(figure, at_rest=True)
    return figure


@styled
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
    draw_mesh(view, assembly)
    draw_plan(plan, assembly)
    draw_side(side, assembly)
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


@styled
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
        draw_section(axes, section, moved, at_rest)
        axes.set_aspect("equal")
        axes.set_xlim(low * MM, high * MM)
        axes.set_ylim(1.25 * at_rest[:, 1].min() * MM, 1.25 * at_rest[:, 1].max() * MM)
        axes.set_title(f"{name}, displacements × {scale:g}", loc="left")
        axes.set_ylabel("z (mm)")
    panels[-1].set_xlabel("x (mm)")
    _explain_parts(figure, at_rest=True)
    return figure


def _explain_parts(figure: Figure, at_rest: bool = False) -> None:
    handles = [Patch(facecolor=c, edgecolor="0.15", linewidth=0.5) for c in PART_COLOURS]
    names = ["bar A", "bar B", "bolts"]
    if at_rest:
        handles.append(Line2D([], [], color="0.65", linewidth=0.9))
        names.append("at rest")
    figure.legend(handles, names, loc="outside upper center", ncols=len(names))


def _round_down(number: float) -> float:
    """The number cut to its first digit."""
    power = 10 ** np.floor(np.log10(number))
    return float(power * np.floor(number / power))
