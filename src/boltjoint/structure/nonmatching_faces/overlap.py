"""Integrals over the common parts of facing faces of two surfaces, whose polygons are clipped.

Polygons of side B are projected on the plane of a polygon of side A and clipped by it. At
integration points of the common parts, straight lines along the normal of that plane lead to places
on both faces: there shape functions of both sides are known, whose products are summed. Each
common part lies within one face of either side, so that functions are smooth in it.

References
----------
I. E. Sutherland, G. W. Hodgman: Reentrant polygon clipping. Communications of the ACM 17 (1974)
32-42.

M. A. Puso, T. A. Laursen: A mortar segment-to-segment contact method for large deformation solid
mechanics. Computer Methods in Applied Mechanics and Engineering 193 (2004) 601-629.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from boltjoint.structure.elements import parent_elements
from boltjoint.structure.elements.parent_elements import TRIANGLE_3, IntegrationRule
from boltjoint.structure.nonmatching_faces.faces import FaceGroup, Polygons

Array = NDArray[np.float64]


def clip_polygons(subject: Array, window: Array) -> Array:
    """The common part of convex polygons, counter-clockwise.

    All polygons of an array have as many vertices: shorter ones repeat a vertex.

    Parameters
    ----------
    subject, window
        Shapes (pairs, m, 2) and (pairs, n, 2).

    Returns
    -------
    ndarray
        Shape (pairs, m + n, 2); where the polygons have nothing in common, all vertices are one.
    """
    polygon = subject
    for edge in range(window.shape[1]):
        polygon = _beside(polygon, window[:, edge - 1], window[:, edge])
    return polygon


def _beside(polygon: Array, start: Array, end: Array) -> Array:
    """The part of polygons left of lines, with one more vertex."""
    pairs, count, _ = polygon.shape
    along = end - start
    apart = polygon - start[:, None]
    distance = along[:, None, 0] * apart[..., 1] - along[:, None, 1] * apart[..., 0]
    following = np.roll(polygon, -1, axis=1)
    distance_after = np.roll(distance, -1, axis=1)
    crosses = (distance >= 0) != (distance_after >= 0)
    change = np.where(crosses, distance - distance_after, 1.0)
    crossing = polygon + (distance / change)[..., None] * (following - polygon)
    # of each side: its start where that is inside, then where it crosses the line
    vertex = np.stack([polygon, crossing], axis=2).reshape(pairs, 2 * count, 2)
    is_kept = np.stack([distance >= 0, crosses], axis=2).reshape(pairs, 2 * count)
    order = np.argsort(~is_kept, axis=1, kind="stable")[:, : count + 1]
    vertex = np.take_along_axis(vertex, order[..., None], axis=1)
    is_kept = np.take_along_axis(is_kept, order, axis=1)
    # what is left over repeats the first vertex
    return np.where(is_kept[..., None], vertex, vertex[:, :1])


def polygon_areas(polygon: Array) -> Array:
    """Areas of polygons, positive where counter-clockwise, shape (pairs,), of (pairs, n, 2)."""
    apart = polygon[:, 1:] - polygon[:, :1]
    one, other = apart[:, :-1], apart[:, 1:]
    return np.sum(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0], axis=1) / 2


def fans(polygon: Array) -> Array:
    """Triangles of convex polygons from their first vertex, shape (pairs, n - 2, 3, 2)."""
    first = np.broadcast_to(polygon[:, :1], polygon[:, 1:-1].shape)
    return np.stack([first, polygon[:, 1:-1], polygon[:, 2:]], axis=2)


#: pairs of polygons that are clipped together
_CHUNK = 2048

#: product of outward normals above which faces look away from each other
_FACING = -0.5

#: common area over that of the smaller polygon that is rounding
_ROUNDING = 1e-10

#: distance over which faces meet, where no other is given, over the radius of the larger one
_NEAR = 0.5

#: common area over that of a face that is all of it
_WHOLE = 1 - 1e-9

#: Gauss points along each direction of a whole face, and of a triangle where functions are no
#: polynomials: there they leave less than 1e-10 of tractions on faces distorted by half their size
_POINTS_OF_FACES, _POINTS_OF_TRIANGLES = 4, 6


@dataclass(frozen=True, eq=False)
class FacePairs:
    """Integrals over the common parts of faces of one group of side A and one of side B.

    With shape functions N_a and N_b of the faces and the area element of side A:

    Attributes
    ----------
    group_a, group_b
        Numbers of the groups.
    face_a, face_b
        Faces of each pair, shape (pairs,).
    own
        Of N_a N_a, shape (pairs, nodes of A, nodes of A) [m2].
    other
        Of N_a N_b, shape (pairs, nodes of A, nodes of B) [m2].
    normal
        Of N_a times the normal of side A, shape (pairs, nodes of A, 3) [m2].
    gap
        Of N_a times the distance along the normal of the plane, shape (pairs, nodes of A) [m3].
    """

    group_a: int
    group_b: int
    face_a: NDArray[np.int64]
    face_b: NDArray[np.int64]
    own: Array
    other: Array
    normal: Array
    gap: Array


def face_pairs(
    sides: tuple[Sequence[FaceGroup], Sequence[FaceGroup]],
    polygons: tuple[Polygons, Polygons],
    largest_gap: float | None,
) -> Iterator[FacePairs]:
    """Pairs of faces that have a part in common, some at a time.

    Parameters
    ----------
    sides
        Faces of side A and of side B.
    polygons
        Flat pieces of them.
    largest_gap
        Distance along the normal up to which faces meet [m]; half the larger radius by default.
    """
    one, other = polygons
    pieces = [np.bincount(one.face[one.group == i]) for i in range(len(sides[0]))]
    for a, b in _candidates(one, other, largest_gap):
        common, a, b = _common_parts(one, other, a, b)
        for i, group_a in enumerate(sides[0]):
            for j, group_b in enumerate(sides[1]):
                own = np.flatnonzero((one.group[a] == i) & (other.group[b] == j))
                if own.size:
                    parts = _Parts(
                        i,
                        j,
                        (group_a, group_b),
                        (one.face[a[own]], other.face[b[own]]),
                        one.centre[a[own]],
                        one.tangents[a[own]],
                        one.normal[a[own]],
                        common[own],
                        _limit(one, other, a[own], b[own], largest_gap),
                    )
                    is_whole = pieces[i][parts.faces[0]] == 1
                    area = polygon_areas(common[own])
                    is_whole &= area > _WHOLE * one.area[a[own]]
                    yield from parts.integrals(is_whole)


def _limit(
    one: Polygons,
    other: Polygons,
    a: NDArray[np.int64],
    b: NDArray[np.int64],
    largest_gap: float | None,
) -> Array:
    """Distance up to which polygons meet [m], shape (pairs,)."""
    if largest_gap is not None:
        return np.full(a.size, largest_gap)
    return _NEAR * np.maximum(one.radius[a], other.radius[b])


def _candidates(
    one: Polygons, other: Polygons, largest_gap: float | None
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Pairs of polygons that are near and face each other, some at a time."""
    tree = cKDTree(other.centre)
    largest = other.radius.max()
    reach = _NEAR * np.maximum(one.radius, largest) if largest_gap is None else largest_gap
    near = tree.query_ball_point(
        one.centre, np.hypot(one.radius + largest, reach) * (1 + 1e-9), return_sorted=True
    )
    counts = np.array([len(faces) for faces in near])
    a = np.repeat(np.arange(len(near)), counts)
    b = np.concatenate([np.asarray(faces, dtype=np.int64) for faces in near])
    facing = np.sum(one.normal[a] * other.normal[b], axis=1) < _FACING
    a, b = a[facing], b[facing]
    for start in range(0, a.size, _CHUNK):
        yield a[start : start + _CHUNK], b[start : start + _CHUNK]


def _common_parts(
    one: Polygons, other: Polygons, a: NDArray[np.int64], b: NDArray[np.int64]
) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
    """Common parts in the planes of side A, shape (pairs, 8, 2), and the pairs that have some."""
    tangents, centre = one.tangents[a], one.centre[a]
    flat = [
        np.einsum("pik,pvk->pvi", tangents, vertex - centre[:, None])
        # side B is seen from behind
        for vertex in (one.vertex[a], other.vertex[b][:, ::-1])
    ]
    touch = np.all(
        (flat[0].min(axis=1) < flat[1].max(axis=1)) & (flat[1].min(axis=1) < flat[0].max(axis=1)),
        axis=1,
    )
    own, opposite, a, b = flat[0][touch], flat[1][touch], a[touch], b[touch]
    common = clip_polygons(opposite, own)
    smaller = np.minimum(polygon_areas(own), polygon_areas(opposite))
    kept = polygon_areas(common) > _ROUNDING * smaller
    return common[kept], a[kept], b[kept]


@dataclass(frozen=True, eq=False)
class _Parts:
    """Common parts of faces of one group of side A and one of side B.

    ``faces`` of both sides (parts,) each; of planes of side A ``centre`` (parts, 3) [m],
    ``tangents`` (parts, 2, 3) and ``normal`` (parts, 3); vertices ``common`` (parts, vertices, 2)
    in them [m]; ``limit`` (parts,), distance up to which faces meet [m].
    """

    group_a: int
    group_b: int
    groups: tuple[FaceGroup, FaceGroup]
    faces: tuple[NDArray[np.int64], NDArray[np.int64]]
    centre: Array
    tangents: Array
    normal: Array
    common: Array
    limit: Array

    def integrals(self, is_whole: NDArray[np.bool_]) -> Iterator[FacePairs]:
        """Integrals over all parts.

        Parameters
        ----------
        is_whole
            Whether a part is all of the face of side A, shape (parts,).
        """
        is_affine = np.logical_and(
            *(group.is_affine[face] for group, face in zip(self.groups, self.faces, strict=True))
        )
        whole = np.flatnonzero(is_whole & ~is_affine)
        if whole.size:
            yield self._sums(*self._points_of_faces(whole))
        polynomial = parent_elements.TRIANGLE_7_POINTS
        for rule, parts in (
            (polynomial, np.flatnonzero(is_affine)),
            (_collapsed_rule(), np.flatnonzero(~is_whole & ~is_affine)),
        ):
            if parts.size:
                yield self._sums(*self._points_of_triangles(parts, rule))

    def _points_of_faces(self, parts: NDArray[np.int64]) -> tuple[NDArray[np.int64], Array, Array]:
        """Part, place on side A and area of integration points of whole faces of side A."""
        one = self.groups[0]
        rule = parent_elements.TRIANGLE_7_POINTS
        if len(one.functions.corner) > 3:
            rule = parent_elements.gauss(_POINTS_OF_FACES, 2)
        place = np.tile(rule.point, (parts.size, 1))
        part = np.repeat(parts, len(rule.weight))
        normal = one.normals(self.faces[0][part], place)
        area = np.tile(rule.weight, parts.size) * np.linalg.norm(normal, axis=1)
        return part, place, area

    def _points_of_triangles(
        self, parts: NDArray[np.int64], rule: IntegrationRule
    ) -> tuple[NDArray[np.int64], Array, Array]:
        """The same of triangles of the common parts."""
        one = self.groups[0]
        triangle = fans(self.common[parts])
        area = polygon_areas(triangle.reshape(-1, 3, 2)).reshape(triangle.shape[:2])
        kept, number = np.nonzero(area > _ROUNDING * area.sum(axis=1, keepdims=True))
        flat = (TRIANGLE_3.values(rule.point) @ triangle[kept, number]).reshape(-1, 2)
        weight = (2 * area[kept, number][:, None] * rule.weight).ravel()
        part = np.repeat(parts[kept], len(rule.weight))
        point = self.centre[part] + np.einsum("pi,pik->pk", flat, self.tangents[part])
        face = self.faces[0][part]
        place = one.places(face, point, self.tangents[part])
        normal = one.normals(face, place)
        # a curved face has more area than its picture in the plane
        cosine = np.sum(normal * self.normal[part], axis=1) / np.linalg.norm(normal, axis=1)
        return part, place, weight / cosine

    def _sums(self, part: NDArray[np.int64], place: Array, area: Array) -> FacePairs:
        """Sums over the points of each pair of faces."""
        one, other = self.groups
        face_a, face_b = (faces[part] for faces in self.faces)
        shape_a = one.functions.values(place)
        point = np.einsum("pa,pak->pk", shape_a, one.coordinate[face_a])
        shape_b = other.functions.values(other.places(face_b, point, self.tangents[part]))
        apart = np.einsum("pa,pak->pk", shape_b, other.coordinate[face_b]) - point
        gap = np.sum(apart * self.normal[part], axis=1)
        normal = one.normals(face_a, place)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        area = np.where(abs(gap) <= self.limit[part], area, 0.0)
        pair = face_a * len(other.connectivity) + face_b
        order = np.argsort(pair, kind="stable")
        start = np.flatnonzero(np.diff(pair[order], prepend=-1))
        weighted = (area[:, None] * shape_a)[:, :, None]
        sums = [
            np.add.reduceat((weighted * values[:, None, :])[order], start, axis=0)
            for values in (shape_a, shape_b, normal, gap[:, None])
        ]
        a, b = np.divmod(pair[order][start], len(other.connectivity))
        kept = sums[0].sum(axis=(1, 2)) > 0
        a, b, own, both, normals, gaps = (values[kept] for values in (a, b, *sums))
        return FacePairs(self.group_a, self.group_b, a, b, own, both, normals, gaps[..., 0])


def _collapsed_rule() -> IntegrationRule:
    """Gauss points of a square whose one side is drawn together to a corner of a triangle."""
    square = parent_elements.gauss(_POINTS_OF_TRIANGLES, 2)
    r, s = (1 + square.point.T) / 2
    return IntegrationRule(np.stack([r, (1 - r) * s], axis=1), square.weight * (1 - r) / 4)
