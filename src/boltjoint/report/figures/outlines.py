"""Outlines of meshes, of sections through them, and of the contact surface."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.path import Path as Shape
from numpy.typing import NDArray

from boltjoint.joint.surface_places import SAME_POINT, SurfacePlaces, pairs_of_elements
from boltjoint.report.figures.style import MM
from boltjoint.structure.elements.kinds import FACES_OF_HEXAHEDRON

#: distance of surfaces that are drawn one above the other, over the side of the largest square
_APART = 3.0


def positions_of(dataset: xr.Dataset, name: str, along: str) -> NDArray[np.float64]:
    """A vector quantity, shape (along, 3)."""
    return dataset[name].transpose(along, "axis").to_numpy()


def element_faces(assembly: xr.Dataset) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces of all elements: nodes, shape (faces, 4), and part, shape (faces,)."""
    connectivity = assembly["connectivity"].transpose("element", "corner").to_numpy()
    faces = connectivity[:, FACES_OF_HEXAHEDRON]
    return faces.reshape(-1, 4), np.repeat(assembly["part"].to_numpy(), faces.shape[1])


def outer_faces(assembly: xr.Dataset) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces that belong to one element only: nodes, shape (faces, 4), and part, shape (faces,)."""
    faces, part = element_faces(assembly)
    _, first, count = np.unique(np.sort(faces), axis=0, return_index=True, return_counts=True)
    outer = first[count == 1]
    return faces[outer], part[outer]


def faces_among_nodes(
    assembly: xr.Dataset, chosen: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces of the elements with all four corners among the chosen nodes, each once.

    Returns the nodes of the faces, shape (faces, 4), and their parts, shape (faces,).
    """
    faces, part = element_faces(assembly)
    indices = np.flatnonzero(chosen[faces].all(axis=1))
    _, first = np.unique(np.sort(faces[indices]), axis=0, return_index=True)
    indices = indices[np.sort(first)]
    return faces[indices], part[indices]


def section_outlines(
    assembly: xr.Dataset, view: NDArray[np.float64], across: str = "y"
) -> dict[int, list[NDArray[np.int64]]]:
    """Outlines, as loops of nodes, of every part where a plane of two axes cuts it."""
    on_plane = np.abs(assembly["coordinate"].sel(axis=across).to_numpy()) < SAME_POINT
    faces, part = faces_among_nodes(assembly, on_plane)
    if len(faces) == 0:
        raise ValueError(f"the mesh has no faces in the plane {across} = 0")
    faces = counter_clockwise(faces, view)
    return {int(p): outline_loops(faces[part == p]) for p in np.unique(part)}


def outline_loops(polygon: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Outline of polygons that share corners, as loops of points; those of holes are clockwise."""
    edges = polygon_edges(polygon).tolist()
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


def polygon_edges(polygon: NDArray[np.int64]) -> NDArray[np.int64]:
    """Both ends of all edges of polygons, one polygon after another, shape (edges, 2)."""
    return np.stack([polygon, np.roll(polygon, -1, axis=1)], axis=-1).reshape(-1, 2)


def long_lines(polygon: NDArray[np.int64]) -> list[list[int]]:
    """Edges of polygons, each once, in long lines, which take fewer points than single edges."""
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


def polygon_area(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area of polygons from their corners, shape (..., corners, 2); negative for clockwise ones."""
    x, y = np.moveaxis(corner, -1, 0)
    return (x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1)).sum(axis=-1) / 2


def counter_clockwise(polygon: NDArray[np.int64], point: NDArray[np.float64]) -> NDArray[np.int64]:
    """Polygons, shape (polygons, corners), with their corners in counter-clockwise order."""
    return np.where(polygon_area(point[polygon])[:, None] < 0, polygon[:, ::-1], polygon)


def closed_shape(point: NDArray[np.float64], loops: Iterable[NDArray[np.int64]]) -> Shape:
    """One shape from several loops of points; it may be empty."""
    closed = [Shape(point[np.append(loop, loop[0])], closed=True) for loop in loops]
    return Shape.make_compound_path(*closed)


@dataclass(frozen=True)
class ContactSurface:
    """The contact surface in plan view, every quadrilateral cut into the shares of its corners.

    Of contact points without a mesh there are no quadrilaterals: each has a square of its area, and
    surfaces are drawn one above the other.

    ``position`` (pairs, 3) [m] in space, ``place`` (pairs, 2) [m] in the plane of the surface, of
    which views are drawn; ``facet`` (facets, 4) pairs; ``corner`` holds the points of the shares in
    mm, ``share`` (shares, 4) their corners and ``owner`` (shares,) their pairs.
    """

    position: NDArray[np.float64]
    place: NDArray[np.float64]
    facet: NDArray[np.int64]
    corner: NDArray[np.float64]
    share: NDArray[np.int64]
    owner: NDArray[np.int64]
    labels: tuple[str, str] = ("x (mm)", "y (mm)")

    @classmethod
    def of(cls, assembly: xr.Dataset) -> "ContactSurface":
        """The contact surface of an assembly."""
        if "pair_node" not in assembly:
            return cls._of_points(assembly)
        position = positions_of(assembly, "position", "pair")
        place = SurfacePlaces.of("assembly", assembly).place
        plan = place * MM
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
            place=place,
            facet=facet,
            corner=np.concatenate([plan, plan[edge].mean(axis=1), plan[facet].mean(axis=1)]),
            share=share.reshape(-1, 4),
            owner=facet.ravel(),
        )

    @classmethod
    def _of_points(cls, assembly: xr.Dataset) -> "ContactSurface":
        places, side = SurfacePlaces.of("assembly", assembly), np.sqrt(assembly["area"].to_numpy())
        place, above = places.place.copy(), 0.0
        for number in np.unique(places.number):
            mine = places.number == number
            place[mine] -= place[mine].min(axis=0)
            place[mine, 1] += above
            above = place[mine, 1].max() + _APART * side.max()
        square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
        corner = place[:, None] + side[:, None, None] * square
        pairs = np.arange(len(place))
        return cls(
            position=positions_of(assembly, "position", "pair"),
            place=place,
            facet=np.zeros((0, 4), dtype=np.int64),
            corner=corner.reshape(-1, 2) * MM,
            share=4 * pairs[:, None] + np.arange(4),
            owner=pairs,
            labels=("along the first tangent (mm)", "second (mm)"),
        )

    def pairs_at(self, joint: xr.Dataset) -> NDArray[np.int64]:
        """The pair that each element of a joint sits on, shape (elements,)."""
        return pairs_of_elements(self.position, joint)

    def area_of(self, pairs: Sequence[int] | NDArray[np.int64]) -> Shape:
        """The area of some pairs, as one shape."""
        return closed_shape(self.corner, outline_loops(self.share[np.isin(self.owner, pairs)]))

    def area_without(self, pairs: Sequence[int] | NDArray[np.int64]) -> Shape:
        """The area of all other pairs, as one shape."""
        return self.area_of(np.setdiff1d(np.arange(len(self.position)), pairs))

    def edges_along_middle(self) -> NDArray[np.int64]:
        """Pairs at both ends of the edges along the middle of the width, shape (edges, 2)."""
        y = self.place[:, 1]
        on_middle = np.abs(y - (y.min() + y.max()) / 2) < SAME_POINT
        edges = polygon_edges(self.facet)
        return np.unique(np.sort(edges[on_middle[edges].all(axis=1)]), axis=0)
