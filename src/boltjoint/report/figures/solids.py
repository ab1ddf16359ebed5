"""Pictures of solid bodies of any cells: bodies, where they are in contact, and how they move."""

from collections.abc import Sequence
from typing import cast

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from boltjoint.report.figures.outlines import positions_of
from boltjoint.report.figures.style import MM, REGION_COLOURS, figure_style
from boltjoint.structure.elements.kinds import KINDS

Array = NDArray[np.float64]

#: kind of a cell by its number of nodes
_KINDS = {
    KINDS[name].nodes: KINDS[name] for name in ("C3D4", "C3D6", "C3D8", "C3D10", "C3D15", "C3D20")
}
#: direction from the bodies to the viewer, who is above them, and to the light
_VIEW, _LIGHT = np.array([-0.35, -1.0, 0.65]), np.array([-0.3, -0.5, 0.81])
#: of bodies, neighbours in number apart
_COLOURS = ("#b9cfe4", "#e6d3b3", "#b5d3b8", "#d9b8c4", "#cfc8e0", "#9c8f80")
#: faces are pictures of dots, of which so many an inch
_DOTS = 220
_WIDTH, _MARGIN = 7.0, 1.2
#: largest displacement that is drawn, over the size of the bodies
_DEFLECTION = 0.05


@figure_style
def plot_solids(assembly: xr.Dataset) -> Figure:
    """Bodies seen from above at an angle, and their contact points through them.

    Parameters
    ----------
    assembly
        With ``coordinate``, ``connectivity`` in the order of VTK, -1 where a cell has fewer nodes,
        ``part`` and the ``position`` and ``surface`` of the contact points.
    """
    node = MM * positions_of(assembly, "coordinate", "node")
    point = MM * positions_of(assembly, "position", "pair")
    face, body = outer_faces(assembly)
    axes_of_view = _axes(node)
    flat = node @ axes_of_view.T
    seen, depth = _visible(node, face, axes_of_view[2])
    shade = _shades(node, face)
    size = np.ptp(flat[:, :2], axis=0)
    height = 2 * _WIDTH * min(size[1] / size[0], 1.0) + _MARGIN
    figure = Figure(figsize=(_WIDTH, height), layout="constrained", dpi=_DOTS)
    above, below = figure.subplots(2, 1)
    colours = np.array([to_rgb(colour) for colour in _COLOURS])[body % len(_COLOURS)]
    order = seen[np.argsort(depth[seen])]
    polygons = flat[face[order], :2]
    _draw(above, polygons, colours[order] * shade[order, None])
    above.set_title("bodies")
    pale = 1 - 0.25 * (1 - colours[order] * shade[order, None])
    _draw(below, polygons, pale)
    names = assembly["surface"].to_numpy().astype(str)
    handles = []
    for number, name in enumerate(dict.fromkeys(names)):
        colour = REGION_COLOURS[number % len(REGION_COLOURS)]
        place = point[names == name] @ axes_of_view.T
        below.plot(*place[:, :2].T, ".", color=colour, markersize=1.5, rasterized=True)
        label = f"{name}: {len(place)} points"
        handles.append(Line2D([], [], marker="o", linestyle="none", color=colour, label=label))
    below.set_title("contact points, seen through the bodies")
    below.legend(handles=handles, loc="upper left", bbox_to_anchor=(0, 0), ncols=3)
    for axes in (above, below):
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.autoscale_view()
    return figure


@figure_style
def plot_solid_modes(assembly: xr.Dataset, modes: xr.Dataset) -> Figure:
    """Elastic modes of bodies, displacements enlarged and by colour.

    Parameters
    ----------
    assembly, modes
        As for ``plot_solids``, and as from ``find_modes``.
    """
    frequency = modes["natural_frequency"].to_numpy()
    shape = modes["mode_shape"].transpose("mode", "node", "axis").to_numpy()
    elastic = np.flatnonzero(frequency > 0)
    titles = [f"mode {i + 1}: {frequency[mode]:.4g} Hz" for i, mode in enumerate(elastic)]
    return _plot_motion(assembly, shape[elastic], titles)


@figure_style
def plot_solid_deformation(assembly: xr.Dataset, preload: xr.Dataset) -> Figure:
    """Bodies under preload, displacements enlarged and by colour.

    Parameters
    ----------
    assembly, preload
        As for ``plot_solids``, and as from ``apply_preload``.
    """
    displacement = positions_of(preload, "displacement", "node")
    largest = 1e6 * np.linalg.norm(displacement, axis=1).max()
    return _plot_motion(assembly, displacement[None], [f"largest displacement {largest:.3g} μm"])


def _plot_motion(assembly: xr.Dataset, shapes: Array, titles: list[str]) -> Figure:
    """Bodies displaced by shapes, (shapes, nodes, 3)."""
    node = MM * positions_of(assembly, "coordinate", "node")
    face, _ = outer_faces(assembly)
    axes_of_view = _axes(node)
    size = np.ptp(node, axis=0).max()
    extent = np.ptp(node @ axes_of_view.T, axis=0)
    height = _WIDTH * min((extent[1] + 2 * _DEFLECTION * size) / extent[0], 1.0) + 0.3
    figure = Figure(figsize=(_WIDTH, height * len(shapes)), layout="constrained", dpi=_DOTS)
    colours_of = matplotlib.colormaps["cividis"]
    for axes, shape, title in zip(
        np.ravel(figure.subplots(len(shapes), 1)), shapes, titles, strict=True
    ):
        motion = np.linalg.norm(shape, axis=1)
        largest = motion.max() or 1.0
        moved = node + _DEFLECTION * size / largest * shape
        seen, depth = _visible(moved, face, axes_of_view[2])
        order = seen[np.argsort(depth[seen])]
        colours = colours_of(motion[face[order]].mean(axis=1) / largest)[:, :3]
        shade = _shades(moved, face)[order, None]
        _draw(axes, (moved @ axes_of_view.T)[face[order], :2], colours * shade)
        axes.set_title(title)
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.autoscale_view()
    return figure


def outer_faces(assembly: xr.Dataset) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Corners of faces that one cell has, shape (faces, 4), those of triangles repeated; bodies."""
    cell = assembly["connectivity"].transpose("element", "corner").to_numpy()
    part = assembly["part"].to_numpy()
    faces, bodies = [], []
    count = np.count_nonzero(cell >= 0, axis=1)
    for nodes in np.unique(count):
        kind, own = _KINDS[int(nodes)], count == nodes
        corner = cell[own][:, np.argsort(kind.vtk_order)]
        for face in kind.corners_of_faces:
            padded = (*face, face[-1])[:4]
            faces.append(corner[:, padded])
            bodies.append(part[own])
    of_bodies, body = np.concatenate(faces), np.concatenate(bodies)
    key = np.sort(np.where(of_bodies == np.roll(of_bodies, 1, axis=1), -1, of_bodies), axis=1)
    _, first, shared = np.unique(key, axis=0, return_index=True, return_counts=True)
    outer = first[shared == 1]
    return of_bodies[outer], body[outer]


def _axes(node: Array) -> Array:
    """Right, up and towards the viewer, as rows: the longest direction goes to the right."""
    turn = np.roll(np.eye(3), np.argmax(np.ptp(node, axis=0)), axis=1)
    towards = _VIEW @ turn / np.linalg.norm(_VIEW)
    upright = turn[2]
    right = np.cross(upright, towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), towards])


def _normals(node: Array, face: NDArray[np.int64]) -> Array:
    corner = node[face]
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    return normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]


def _visible(
    node: Array, face: NDArray[np.int64], towards: Array
) -> tuple[NDArray[np.intp], Array]:
    """Faces that look at the viewer, and how near all are."""
    seen = np.flatnonzero(_normals(node, face) @ towards > 0)
    return seen, node[face].mean(axis=1) @ towards


def _shades(node: Array, face: NDArray[np.int64]) -> Array:
    """Brightness of faces by how they look at the light."""
    return 0.72 + 0.28 * np.clip(_normals(node, face) @ _LIGHT, 0, 1)


def _draw(axes: Axes, polygons: Array, colours: Array) -> None:
    edges = np.clip(colours * 0.85, 0, 1)
    axes.add_collection(
        PolyCollection(
            cast("Sequence[Array]", polygons),
            facecolors=colours,
            edgecolors=edges,
            linewidths=0.15,
            rasterized=True,
        )
    )
