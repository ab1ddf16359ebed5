"""Views of the mesh of a half lap, and the dimensions in them that keys of its YAML file set.

Lengths are in millimetres: x from the clamp along the bar, y across its width, z upwards.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.config.lap_joint import LapJoint
from boltjoint.joint.surface_places import SAME_POINT
from boltjoint.report.figures.outlines import counter_clockwise, faces_among_nodes
from boltjoint.report.figures.style import MM
from boltjoint.structure.extrusion.bolt_mesh import radii_of
from boltjoint.structure.extrusion.bolt_plan import bolt_plan
from boltjoint.structure.makers.half_lap.mesh import build_assembly, divisions_of
from boltjoint.structure.makers.half_lap.parts import part_kinds

Place = tuple[float, float]
Align = Literal["left", "center", "right"]

#: a circle of nodes is a polygon of the same area, whose corners lie this much outside of it [mm]
_OUTSIDE_CIRCLE = 0.1


@dataclass(frozen=True)
class Dimension:
    """A dimension that a key sets: a length, or a number of elements.

    Attributes
    ----------
    key
        Its path in the YAML file, such as ``mesh.rings_under_head``.
    begin, end
        Nodes between which it is measured.
    apart
        Distance of the dimension line from them: upwards or to the right where positive.
    text
        Where its text stands, by default beside the middle of the line.
    align
        Which part of the text stands there.
    leader
        Whether a line leads from the dimension to its text.
    tip
        Where the leader of a diameter touches the circle.
    """

    key: str
    begin: Place
    end: Place
    apart: float = 0.0
    text: Place | None = None
    align: Align = "center"
    leader: bool = False
    tip: Place | None = None

    @property
    def label(self) -> str:
        """The key as it stands in the file, with its place in a list."""
        return self.key.rpartition(".")[2]

    @property
    def counts_elements(self) -> bool:
        """Whether it is a number of elements."""
        return self.key.startswith("mesh.") and not self.key.endswith("_mm")

    @property
    def length(self) -> float:
        """Distance of both nodes along the dimension line [mm]."""
        axis = int(self.is_upright)
        return abs(self.end[axis] - self.begin[axis])

    @property
    def is_upright(self) -> bool:
        """Whether it is measured along the second axis of its view."""
        return abs(self.end[1] - self.begin[1]) > abs(self.end[0] - self.begin[0])

    def written(self, place: Place, align: Align, *, leader: bool = False) -> "Dimension":
        """The same dimension with its text at a place."""
        return replace(self, text=place, align=align, leader=leader)


@dataclass(frozen=True, eq=False)
class Cut:
    """The mesh where a plane of two axes cuts it.

    ``point`` (nodes, 2); ``face`` (faces, 4), their nodes, and ``kind`` (faces,), the parts that
    they belong to. Of two faces on one another it is that of the lower bar.
    """

    point: NDArray[np.float64]
    face: NDArray[np.int64]
    kind: NDArray[np.str_]

    @classmethod
    def across(cls, mesh: xr.Dataset, axis: Literal["y", "z"]) -> "Cut":
        """The cut in the middle of an axis."""
        seen = mesh["coordinate"].sel(axis=["x", "z" if axis == "y" else "y"]).to_numpy() * MM
        on_plane = np.abs(mesh["coordinate"].sel(axis=axis).to_numpy()) < SAME_POINT
        face, part = faces_among_nodes(mesh, on_plane)
        centre = np.round(seen[face].mean(axis=1), 6)
        _, first = np.unique(centre, axis=0, return_index=True)
        face, part = counter_clockwise(face[first], seen), part[first]
        return cls(seen, face, np.array(part_kinds(mesh))[part])

    @cached_property
    def _nodes(self) -> NDArray[np.float64]:
        return self.point[np.unique(self.face)]

    def node(self, x: float, y: float) -> Place:
        """The node at a place.

        Raises
        ------
        ValueError
            If there is none.
        """
        distance = np.hypot(*(self._nodes - [x, y]).T)
        if distance.min() > _OUTSIDE_CIRCLE:
            raise ValueError(f"the mesh has no node at {x:g} mm, {y:g} mm")
        first, second = self._nodes[np.argmin(distance)].tolist()
        return first, second

    def elements_between(self, begin: Place, end: Place) -> int:
        """Number of elements along the line between two nodes."""
        line = np.subtract(end, begin)
        length = np.hypot(*line)
        along, beside = np.stack([line, line[::-1] * [-1, 1]]) @ (self._nodes - begin).T / length
        on_line = (abs(beside) < 1e-3) & (along > -1e-3) & (along < length + 1e-3)
        # nodes of two parts may lie on one another
        return int((np.diff(np.sort(along[on_line])) > 1e-3).sum())


@dataclass(frozen=True, eq=False)
class View:
    """A part of a cut, and its dimensions.

    Attributes
    ----------
    title
        What it shows.
    cut, window
        The cut, and the ends of the part along both axes.
    dimensions
        Those that are drawn in it.
    circles, edges
        Bold lines: circles by middle and radius, and straight ones along the second axis.
    has_lines
        Whether the lines of the mesh are drawn.
    """

    title: str
    cut: Cut
    window: tuple[Place, Place]
    dimensions: tuple[Dimension, ...]
    circles: tuple[tuple[Place, float], ...] = ()
    edges: tuple[float, ...] = ()
    has_lines: bool = True


def views_of(assembly: LapJoint, with_washers: LapJoint) -> tuple[View, View, View, View]:
    """The views of an assembly: whole, its lap from above, a bolt, and a bolt with washers."""
    mesh, mesh_with_washers = build_assembly(assembly), build_assembly(with_washers)
    section = Cut.across(mesh, "y")
    return (
        whole_view(assembly, section),
        plan_view(assembly, Cut.across(mesh, "z")),
        bolt_view(assembly, section),
        washer_view(with_washers, Cut.across(mesh_with_washers, "y")),
    )


def whole_view(assembly: LapJoint, cut: Cut) -> View:
    """The whole assembly from the side."""
    bar, bolts = assembly.bar, assembly.bolts
    low, lap = -bar.height_mm / 2, bar.free_length_mm[0]
    x = [0.0, lap, lap + bar.lap_mm, bar.length_mm]
    keys = ("bar.free_length_mm[0]", "bar.lap_mm", "bar.free_length_mm[1]")
    dimensions = tuple(
        Dimension(key, cut.node(begin, low), cut.node(end, low), -bolts.nut_height_mm - 6.0)
        for key, begin, end in zip(keys, x[:-1], x[1:], strict=True)
    )
    reach = bar.height_mm / 2 + bolts.nut_height_mm + bolts.head_height_mm
    return View(
        "the whole assembly, clamped at its left end",
        cut,
        ((0.0, bar.length_mm), (-reach, reach)),
        dimensions,
        has_lines=False,
    )


def plan_view(assembly: LapJoint, cut: Cut) -> View:
    """The contact surface from above, from the start of the lap to the second bolt."""
    bar, half = assembly.bar, assembly.bar.width_mm / 2
    lap = bar.free_length_mm[0]
    element = lap / assembly.elements_outside_lap[0]
    first, second = (lap + position for position in assembly.bolt_positions_mm[:2])
    cell = assembly.mesh.bolt_cell_length_mm / 2
    window = lap - 1.5 * element, second + cell + 2.0
    corners = cut.node(lap, -half), cut.node(lap, half)
    ends = cut.node(lap - element, -half), cut.node(lap - element, half)
    left = window[0] - lap + element
    dimensions = (
        *_cells(cut, (lap, first - cell, first + cell, second - cell), half),
        *_axes_of_bolts(cut, corners[1], (first, second)),
        Dimension("mesh.element_length_free_mm", ends[0], corners[0], -1.5),
        Dimension("mesh.ring_cells_across_width", *ends, left - 1.5),
        Dimension("bar.width_mm", *ends, left - 5.0),
        *_rings(assembly, cut, first),
        *_diameters(assembly, cut, second, window[1] + 1.0),
    )
    head = assembly.bolts.head_diameter_mm / 2
    return View(
        "the contact surface of the lower bar, from above",
        cut,
        (window, (-half, half)),
        dimensions,
        circles=tuple(((axis, 0.0), head) for axis in (first, second)),
        edges=tuple(axis + end for axis in (first, second) for end in (-cell, cell)),
    )


def _cells(cut: Cut, ends: tuple[float, ...], edge: float) -> list[Dimension]:
    """The first columns, a cell and the columns behind it, above the edge of the plan."""
    keys = "columns_at_each_lap_end", "ring_cells_along_bar", "columns_between_bolt_cells"
    node = [cut.node(x, edge) for x in ends]
    before, cell, behind = (
        Dimension(f"mesh.{key}", *pair, 1.5) for key, pair in zip(keys, pairwise(node), strict=True)
    )
    return [
        before.written((ends[1] - 0.5, edge + 2.0), "right"),
        cell,
        behind.written((ends[2] + 0.5, edge + 2.0), "left"),
        Dimension("mesh.bolt_cell_length_mm", node[1], node[2], 5.0),
    ]


def _axes_of_bolts(cut: Cut, start: Place, axes: tuple[float, float]) -> list[Dimension]:
    """Places of bolts from a corner of the lap."""
    first, second = (cut.node(x, 0.0) for x in axes)
    return [
        Dimension("bolts.positions_from_lap_start_mm[0]", start, first, 8.5),
        Dimension("bolts.positions_from_lap_start_mm[1]", start, second, 12.0),
        Dimension("bolts.pitch_mm", first, second, start[1] + 8.5),
    ]


def _rings(assembly: LapJoint, cut: Cut, axis: float) -> list[Dimension]:
    """Rings of a bolt and its cell in the direction of the bar, with texts below the plan."""
    bolts, mesh = assembly.bolts, assembly.mesh
    core = (mesh.ring_cells_across_width + 1) * (mesh.ring_cells_along_bar + 1)
    inside = bolt_plan(radii_of(bolts), divisions_of(assembly)).shank.point[:core] * MM
    reach = inside[abs(inside[:, 1]) < 1e-6, 0].max()
    ends = {
        "mesh.rings_head_to_cell_edge": (bolts.head_diameter_mm, mesh.bolt_cell_length_mm),
        "mesh.rings_under_head": (bolts.hole_diameter_mm, bolts.head_diameter_mm),
        "mesh.rings_in_shank": (2 * reach, bolts.shank_diameter_mm),
    }
    dimensions = []
    for row, (key, (inner, outer)) in enumerate(ends.items()):
        middle, below = axis + (inner + outer) / 4, -assembly.bar.width_mm / 2 - 1.5 - 2.2 * row
        begin, end = (cut.node(axis + diameter / 2, 0.0) for diameter in (inner, outer))
        dimensions.append(Dimension(key, begin, end).written((middle, below), "left", leader=True))
    return dimensions


def _diameters(assembly: LapJoint, cut: Cut, axis: float, beside: float) -> list[Dimension]:
    """Diameters of a bolt, with texts beside the plan."""
    dimensions = []
    rows = {"head": (38.0, 6.5), "hole": (12.0, 1.5), "shank": (-25.0, -3.5)}
    for name, (angle, height) in rows.items():
        radius = getattr(assembly.bolts, f"{name}_diameter_mm") / 2
        angle = np.deg2rad(angle)
        tip = axis + radius * np.cos(angle), radius * np.sin(angle)
        begin, end = cut.node(axis - radius, 0.0), cut.node(axis + radius, 0.0)
        dimension = Dimension(f"bolts.{name}_diameter_mm", begin, end, tip=tip)
        dimensions.append(dimension.written((beside, height), "left", leader=True))
    return dimensions


def bolt_view(assembly: LapJoint, cut: Cut) -> View:
    """The start of the lap from the side, with its first bolt."""
    bar, bolts, mesh = assembly.bar, assembly.bolts, assembly.mesh
    lap, half = bar.free_length_mm[0], bar.height_mm / 2
    axis, edge = lap + assembly.bolt_positions_mm[0], bolts.head_diameter_mm / 2
    element, cell_end = lap / assembly.elements_outside_lap[0], axis + mesh.bolt_cell_length_mm / 2
    left, right = lap - 1.5 * element, cell_end + 2.0
    below, above = -half - bolts.nut_height_mm, half + bolts.head_height_mm

    def upright(key: str, x: float, low: float, high: float, line: float) -> Dimension:
        apart, middle = line - x, (low + high) / 2
        dimension = Dimension(key, cut.node(x, low), cut.node(x, high), apart)
        place = line + float(np.copysign(0.8, apart)), middle
        return dimension.written(place, "left" if apart > 0 else "right")

    ends = cut.node(lap - element, -half), cut.node(lap - element, half)
    dimensions = (
        Dimension("bar.height_mm", *ends, left - lap + element - 1.5),
        upright("mesh.layers_per_half_height", cell_end, 0.0, half, right + 1.0),
        upright("mesh.layers_per_half_height", cell_end, -half, 0.0, right + 1.0),
        upright("mesh.layers_in_head", axis + edge, half, above, axis + edge + 1.5),
        upright("mesh.layers_in_head", axis + edge, below, -half, axis + edge + 1.5),
        upright("bolts.head_height_mm", axis - edge, half, above, axis - edge - 1.5),
        upright("bolts.nut_height_mm", axis - edge, below, -half, axis - edge - 1.5),
    )
    return View(
        "the first bolt, cut along the middle", cut, ((left, right), (below, above)), dimensions
    )


def washer_view(assembly: LapJoint, cut: Cut) -> View:
    """The head of a bolt from the side, with a washer under it."""
    bolts, washer = assembly.bolts, assembly.bolts.washer
    if washer is None or washer.hole_diameter_mm is None or not bolts.has_wide_washers:
        raise ValueError("washer: must be wider than the head, with a hole of its own")
    axis = assembly.bar.free_length_mm[0] + assembly.bolt_positions_mm[0]
    face = assembly.bar.height_mm / 2
    top = face + washer.thickness_mm
    head, edge, hole = (
        diameter / 2
        for diameter in (bolts.head_diameter_mm, washer.diameter_mm, washer.hole_diameter_mm)
    )
    window = (axis - edge - 1.0, axis + edge + 1.0), (face - 3.5, top + bolts.head_height_mm)

    def along(key: str, begin: float, end: float, z: float, apart: float) -> Dimension:
        return Dimension(key, cut.node(axis + begin, z), cut.node(axis + end, z), apart)

    def upright(key: str, x: float, line: float) -> Dimension:
        return Dimension(key, cut.node(x, face), cut.node(x, top), line - x)

    rim = along("mesh.rings_head_to_washer_edge", head, edge, top, 0.7)
    dimensions = (
        along("bolts.washer.diameter_mm", -edge, edge, top, bolts.head_height_mm + 3.4),
        rim.written((axis + edge + 1.0, window[1][1] + 1.0), "right", leader=True),
        along("bolts.washer.hole_diameter_mm", -hole, hole, face, -4.6),
        upright("bolts.washer.thickness_mm", axis - edge, window[0][0] - 0.7),
        upright("mesh.layers_in_washer", axis + edge, window[0][1] + 0.7),
    )
    return View("keys of bolts.washer", cut, window, dimensions)
