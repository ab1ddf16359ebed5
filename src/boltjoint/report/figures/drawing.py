"""Outlines of meshes and contact surfaces."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import PathPatch, Polygon, Rectangle
from matplotlib.path import Path as Shape
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, KDTree

from boltjoint.report.figures.style import (
    BLANK_COLOUR,
    MM,
    PART_COLOURS,
    SAME_POINT,
    counter_clockwise,
    element_faces,
    faces_among_nodes,
    fill_shapes,
    outline_loops,
    polygon_area,
    polygon_edges,
    positions_of,
    section_outlines,
)
from boltjoint.structure.half_lap.mesh import FIRST_BOLT

#: where the viewer of the mesh stands, seen from the assembly; he must be above it
_VIEW = (-0.35, -1.0, 0.65)


#: where the light comes from, and how many tones it makes
_LIGHT, _TONES = np.array([-0.3, -0.5, 0.81]), 16


#: length of the arrows at force and response, and distance of dimension lines [mm]
_ARROW, _BESIDE = 25.0, 7.0


def draw_section(
    axes: Axes,
    section: Mapping[int, Sequence[NDArray[np.int64]]],
    point: NDArray[np.float64],
    at_rest: NDArray[np.float64] | None = None,
) -> None:
    """Fill every part of a section, its points [m] where they are, over its outline at rest."""
    for part, loops in section.items():
        if at_rest is not None:
            rest = [at_rest[np.append(loop, loop[0])] * MM for loop in loops]
            axes.add_collection(LineCollection(rest, colors="0.65", linewidths=0.6, zorder=1))
        # an outline of bolts would show where their shanks are cut to be tightened
        width = 0.5 if part < FIRST_BOLT else 0.0
        look = {"facecolors": PART_COLOURS[min(part, 2)], "edgecolors": "0.15", "linewidths": width}
        fill_shapes(axes, [_shape(point * MM, loops)], **look, zorder=2)


def draw_mesh(axes: Axes, assembly: xr.Dataset) -> None:
    """Draw the mesh from above at an angle, and mark the clamped nodes, force and response."""
    towards = np.array(_VIEW) / np.linalg.norm(_VIEW)
    right = np.array([-towards[1], towards[0], 0.0]) / np.hypot(*towards[:2])
    onto_paper = np.stack([right, np.cross(towards, right)], axis=-1)
    point = positions_of(assembly, "coordinate", "node") * MM
    drawn = point @ onto_paper
    for faces, part, light in _visible_faces(assembly, point, towards):
        colour = light * np.array(to_rgb(PART_COLOURS[min(part, 2)]))
        thin = {"edgecolors": "0.2", "linewidths": 0.15}
        fill_shapes(axes, [_shape(drawn, outline_loops(faces))], facecolors=colour, **thin)
        # bolts are too dark, and their elements too small, to show lines
        if part < FIRST_BOLT:
            lines = Shape.make_compound_path(*(Shape(drawn[line]) for line in _strokes(faces)))
            fill_shapes(axes, [lines], facecolors="none", **thin)
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
    low, high = of_bars.min(axis=0) + SAME_POINT, of_bars.max(axis=0) - SAME_POINT
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


def draw_plan(axes: Axes, assembly: xr.Dataset) -> None:
    """Draw the contact surface with its holes, the bars around it, and lengths."""
    surface = ContactSurface.of(assembly)
    everything = surface.area_of(np.arange(len(surface.position)))
    x, y, _ = _bounds_of_bars(assembly)
    look = {"edgecolor": "0.15", "linewidth": 0.5}
    axes.add_patch(Rectangle((x[0], y[0]), np.ptp(x), np.ptp(y), facecolor="white", **look))
    axes.add_patch(PathPatch(everything, facecolor=BLANK_COLOUR, **look))
    lap = everything.get_extents().intervalx
    bolts = assembly["bolt_position"].sel(axis="x").to_numpy() * MM
    for begin, end in pairwise([lap[0], *bolts, lap[1]]):
        _dimension(axes, (begin, y[0] - _BESIDE), (end, y[0] - _BESIDE))
    _dimension(axes, (x[0] - _BESIDE, y[0]), (x[0] - _BESIDE, y[1]))
    # loops around holes run back
    hole = max(-polygon_area(loop[:-1]) for loop in everything.to_polygons())
    axes.text(lap[1] + 3, 0, f"holes ⌀ {2 * np.sqrt(hole / np.pi):.4g}", va="center", fontsize=8)


def draw_side(axes: Axes, assembly: xr.Dataset) -> None:
    """Draw the assembly cut along the middle of its width, and lengths."""
    point = positions_of(assembly, "coordinate", "node")[:, [0, 2]]
    draw_section(axes, section_outlines(assembly, point), point)
    x, _, z = _bounds_of_bars(assembly)
    lap = assembly["position"].sel(axis="x").to_numpy() * MM
    below = point[:, 1].min() * MM - _BESIDE
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


@dataclass(frozen=True)
class ContactSurface:
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
    def of(cls, assembly: xr.Dataset) -> "ContactSurface":
        position = positions_of(assembly, "position", "pair")
        plan = position[:, :2] * MM
        pair_of_node = np.full(assembly.sizes["node"], -1)
        pair_of_node[assembly["pair_node"].transpose("pair", "side")[:, 0]] = np.arange(len(plan))
        nodes, _ = faces_among_nodes(assembly, pair_of_node >= 0)
        facet = counter_clockwise(pair_of_node[nodes], plan)
        # middles of edges are numbered once for the two facets they belong to
        edge, of_facet = np.unique(np.sort(polygon_edges(facet)), axis=0, return_inverse=True)
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
        element = positions_of(joint, "element_position", "element")
        distance, pair = KDTree(self.position).query(element)
        if distance.max() > SAME_POINT:
            raise ValueError(f"{np.sum(distance > SAME_POINT)} elements lie on no contact pair")
        return pair

    def area_of(self, pairs: Sequence[int] | NDArray[np.int64]) -> Shape:
        """What belongs to some pairs, as one shape."""
        return _shape(self.corner, outline_loops(self.share[np.isin(self.owner, pairs)]))

    def edges_along_middle(self) -> NDArray[np.int64]:
        """Pairs at both ends of the edges along the middle of the width, shape (edges, 2)."""
        y = self.position[:, 1]
        on_middle = np.abs(y - (y.min() + y.max()) / 2) < SAME_POINT
        edges = polygon_edges(self.facet)
        return np.unique(np.sort(edges[on_middle[edges].all(axis=1)]), axis=0)


def _outer_faces(assembly: xr.Dataset) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces that belong to one element only: nodes, shape (faces, 4), and part, shape (faces,)."""
    faces, part = element_faces(assembly)
    _, first, count = np.unique(np.sort(faces), axis=0, return_index=True, return_counts=True)
    outer = first[count == 1]
    return faces[outer], part[outer]


def _bounds_of_bars(assembly: xr.Dataset) -> NDArray[np.float64]:
    """Where both bars together begin and end [mm] along x, y and z, shape (3, 2)."""
    of_bars = assembly["connectivity"].to_numpy()[assembly["part"].to_numpy() < FIRST_BOLT]
    point = positions_of(assembly, "coordinate", "node")[np.unique(of_bars)] * MM
    return np.stack([point.min(axis=0), point.max(axis=0)], axis=-1)


def _strokes(polygon: NDArray[np.int64]) -> list[list[int]]:
    """Edges of polygons, each once, in lines as long as can be: few points to write down."""
    neighbours = defaultdict(set)
    for begin, end in polygon_edges(polygon).tolist():
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
