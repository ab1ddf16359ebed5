"""Contact points of two surfaces whose faces need not match, as weighted means over segments.

A point i has a function phi_i on side A; together they sum to one. Its relative displacement is the
mean over the common parts of both surfaces, weighted by it::

    B_i = 1/w_i int phi_i (N_A - N_B) dA,   w_i = int phi_i dA

so that a uniform traction has the same, exact resultant on both sides. The functions are one on a
face of side A and zero on others, for any kind of face, or those dual to the shape functions of
linear faces: then a point belongs to a node of side A, moves as it does there, and is the pair of
two nodes where nodes of both sides coincide.

References
----------
B. I. Wohlmuth: A mortar finite element method using dual spaces for the Lagrange multiplier. SIAM
Journal on Numerical Analysis 38 (2000) 989-1012.
A. Popp, A. Seitz, M. W. Gee, W. A. Wall: Improved robustness and consistency of 3D contact
algorithms based on a dual mortar approach. Computer Methods in Applied Mechanics and Engineering
264 (2013) 67-80.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint import checks
from boltjoint.structure.contact_points import DIRECTIONS, ContactPoints
from boltjoint.structure.nonmatching_faces.faces import FaceGroup, face_groups, polygons_of
from boltjoint.structure.nonmatching_faces.overlap import FacePairs, face_pairs

Array = NDArray[np.float64]

#: functions of the points
WEIGHTINGS = ("face", "dual")

#: smallest eigenvalue of the normalised matrix of int N_a N_a over the common part of a face: below
#: it the face has a sliver in common, where dual functions are large, and shape functions are taken
_SLIVER = 0.01

#: entry of a row or a normal, whose largest are about one, that is rounding
_ROUNDING = 1e-13

#: gap over the size of a point that is rounding
_FLAT = 1e-9

#: length of the tangent direction within the surface, over the whole, below which there is none
_ALONG = 0.05


@dataclass(frozen=True, eq=False)
class WeightedPoints:
    """Contact points of two surfaces by the nodes of a mesh.

    Attributes
    ----------
    rows
        B: factors of the displacements of nodes in the relative displacement of side A minus side
        B, shape (points, nodes).
    position
        On side A [m], shape (points, 3).
    frame
        Two tangents and the normal, from side A to side B, shape (points, 3, 3).
    area
        w [m2], shape (points,).
    gap
        Mean distance along the normal, negative where the surfaces penetrate [m], shape (points,).
    """

    rows: sparse.csr_array
    position: Array
    frame: Array
    area: Array
    gap: Array

    def contact_points(
        self,
        displacement: sparse.sparray | None = None,
        *,
        surface: str = "contact",
        penalty: float = 1e15,
        friction_coefficient: float = 0.0,
    ) -> ContactPoints:
        """The points as a structure has them; those that penetrate touch.

        Parameters
        ----------
        displacement
            Displacements of the nodes along x, y, z, one node after another, from degrees of
            freedom, shape (3 * nodes, dofs); by default they are the same.
        surface, penalty, friction_coefficient
            As the attributes of ``ContactPoints``, of all points.
        """
        points = len(self.area)
        along = sparse.bsr_array(
            (self.frame, np.arange(points), np.arange(points + 1)),
            shape=(DIRECTIONS * points, DIRECTIONS * points),
        )
        relative = along @ sparse.kron(self.rows, sparse.eye_array(DIRECTIONS), format="csr")
        if displacement is not None:
            relative = relative @ displacement
        relative = sparse.csr_array(relative)
        # products of directions along the axes
        relative.eliminate_zeros()
        return ContactPoints(
            relative,
            position=self.position,
            frame=self.frame,
            area=self.area,
            surface=np.array(surface),
            gap=np.maximum(self.gap, 0.0),
            penalty=np.full(points, penalty),
            friction_coefficient=np.full(points, friction_coefficient),
        )


def weighted_points(
    coordinate: Array,
    side_a: Sequence[NDArray[np.integer]],
    side_b: Sequence[NDArray[np.integer]],
    along: Array,
    *,
    weighting: str = "face",
    largest_gap: float | None = None,
) -> WeightedPoints:
    """Contact points of the common parts of two surfaces.

    Faces of side A without a face of side B before them have no point.

    Parameters
    ----------
    coordinate
        Nodes of the mesh, shape (nodes, 3) [m].
    side_a, side_b
        Nodes of the faces of either side, corners first and seen from outside the body, an array
        (faces, nodes) of each number of nodes: 3, 4, 6 or 8.
    along
        Direction that the first tangents follow, shape (3,).
    weighting
        ``face``: a point for each face of side A; ``dual``: for each of its nodes.
    largest_gap
        Distance along the normal up to which faces meet [m]; by default half the largest distance
        of a corner from the middle of the larger face.

    Raises
    ------
    ValueError
        If the surfaces have no part in common, the direction is normal to one of them, or faces
        with middle nodes are to have dual functions.
    """
    coordinate = checks.array("coordinate", coordinate, ("nodes", 3))
    along = checks.array("along", along, (3,))
    if not along.any():
        raise ValueError("along is zero: it must be a direction")
    checks.choice("weighting", weighting, WEIGHTINGS)
    if largest_gap is not None:
        checks.number("largest_gap", largest_gap, above=0)
    sides = (
        face_groups("side_a", coordinate, side_a),
        face_groups("side_b", coordinate, side_b),
    )
    if weighting == "dual" and not all(group.is_linear for group in sides[0]):
        raise ValueError("weighting 'dual' is of faces without middle nodes: choose 'face'")
    polygons = polygons_of(sides[0]), polygons_of(sides[1])
    pairs = [pair for pair in face_pairs(sides, polygons, largest_gap) if pair.face_a.size]
    if not pairs:
        raise ValueError(
            "no part of side_b lies before side_a: the surfaces do not meet, or look away from "
            "each other"
        )
    sums = _Sums.of_faces if weighting == "face" else _Sums.of_nodes
    return sums(sides, pairs, len(coordinate)).points(coordinate, along)


@dataclass(frozen=True, eq=False)
class _Sums:
    """Integrals of phi_i times N_A and N_B, the normal and the gap, of points i.

    ``own`` and ``other`` (points, nodes) [m2], ``normal`` (points, 3) [m2], ``gap`` (points,) [m3].
    """

    own: sparse.csr_array
    other: sparse.csr_array
    normal: Array
    gap: Array

    @classmethod
    def of_faces(
        cls, sides: tuple[list[FaceGroup], list[FaceGroup]], pairs: list[FacePairs], nodes: int
    ) -> "_Sums":
        """Of functions that are one on a face."""
        first = np.cumsum([0, *(len(group.connectivity) for group in sides[0])])
        collected = _Entries(first[-1], nodes)
        for pair in pairs:
            group_a, group_b = sides[0][pair.group_a], sides[1][pair.group_b]
            # shape functions sum to one
            collected.add(
                (first[pair.group_a] + pair.face_a)[:, None],
                (group_a.connectivity[pair.face_a], group_b.connectivity[pair.face_b]),
                *(integral.sum(axis=1, keepdims=True) for integral in _integrals(pair)),
            )
        return collected.sums()

    @classmethod
    def of_nodes(
        cls, sides: tuple[list[FaceGroup], list[FaceGroup]], pairs: list[FacePairs], nodes: int
    ) -> "_Sums":
        """Of functions that are dual to the shape functions on each face."""
        collected = _Entries(nodes, nodes)
        turns = [
            _dual_functions(group, [pair for pair in pairs if pair.group_a == i])
            for i, group in enumerate(sides[0])
        ]
        for pair in pairs:
            group_a, group_b = sides[0][pair.group_a], sides[1][pair.group_b]
            turn = turns[pair.group_a][pair.face_a]
            own = group_a.connectivity[pair.face_a]
            collected.add(
                own,
                (own, group_b.connectivity[pair.face_b]),
                *(turn @ integral for integral in _integrals(pair)),
            )
        return collected.sums()

    def points(self, coordinate: Array, along: Array) -> WeightedPoints:
        """The points that have a part of the surfaces."""
        area = self.own.sum(axis=1)
        kept = np.flatnonzero(area > 0)
        area = area[kept]
        share = sparse.diags_array(1 / area)
        own, other = (share @ side[kept] for side in (self.own, self.other))
        rows = sparse.csr_array(own - other)
        rows.data[abs(rows.data) < _ROUNDING] = 0.0
        rows.eliminate_zeros()
        position = own @ coordinate
        frame = _frames(self.normal[kept], along, position)
        gap = self.gap[kept] / area
        gap = np.where(abs(gap) > _FLAT * np.sqrt(area), gap, 0.0)
        return WeightedPoints(rows, position, frame, area, gap)


def _integrals(pair: FacePairs) -> tuple[Array, Array, Array, Array]:
    return pair.own, pair.other, pair.normal, pair.gap[..., None]


def _dual_functions(group: FaceGroup, pairs: list[FacePairs]) -> Array:
    """Factors of shape functions in dual ones, shape (faces, functions, nodes).

    ``D M^-1`` of M = int N N^T over the common part of each face, D = diag int N; of faces with
    slivers in common the unit matrix.
    """
    faces, count = group.connectivity.shape
    M = np.zeros((faces, count, count))
    for pair in pairs:
        np.add.at(M, pair.face_a, pair.own)
    D = M.sum(axis=2)
    met = np.flatnonzero(D.sum(axis=1) > 0)
    scale = 1 / np.sqrt(D[met])
    lowest = np.linalg.eigvalsh(scale[:, :, None] * M[met] * scale[:, None, :])[:, 0]
    dual = met[lowest > _SLIVER]
    turn = np.broadcast_to(np.eye(count), M.shape).copy()
    # M is symmetric
    turn[dual] = np.linalg.solve(M[dual], D[dual][:, :, None] * np.eye(count)).swapaxes(1, 2)
    return turn


class _Entries:
    """Sums of points, entry by entry."""

    def __init__(self, points: int, nodes: int) -> None:
        self._shape = points, nodes
        self._parts: list[list[tuple[Array, NDArray[np.int64], NDArray[np.int64]]]] = [[], []]
        self._normal, self._gap = np.zeros((points, 3)), np.zeros(points)

    def add(
        self,
        point: NDArray[np.int64],
        nodes: tuple[NDArray[np.int64], NDArray[np.int64]],
        own: Array,
        other: Array,
        normal: Array,
        gap: Array,
    ) -> None:
        """Add integrals of faces, (faces, functions, ...), of points (faces, functions)."""
        for part, columns, values in zip(self._parts, nodes, (own, other), strict=True):
            row = np.broadcast_to(point[:, :, None], values.shape).ravel()
            column = np.broadcast_to(columns[:, None, :], values.shape).ravel()
            part.append((values.ravel(), row, column))
        np.add.at(self._normal, point, normal)
        np.add.at(self._gap, point, gap[..., 0])

    def sums(self) -> _Sums:
        """All that was added."""
        own, other = (
            sparse.coo_array(
                (
                    np.concatenate([values for values, _, _ in part]),
                    tuple(np.concatenate([piece[i] for piece in part]) for i in (1, 2)),
                ),
                shape=self._shape,
            ).tocsr()
            for part in self._parts
        )
        return _Sums(own, other, self._normal, self._gap)


def _frames(normal: Array, along: Array, position: Array) -> Array:
    """Tangents and normals of points, shape (points, 3, 3)."""
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    normal[abs(normal) < _ROUNDING] = 0.0
    direction = along / np.linalg.norm(along)
    first = direction - (normal @ direction)[:, None] * normal
    length = np.linalg.norm(first, axis=1)
    if length.min() < _ALONG:
        place = ", ".join(f"{x:.6g}" for x in position[np.argmin(length)])
        raise ValueError(
            f"along {direction} is normal to the surface at ({place}) m: it must be a direction "
            "within it"
        )
    first /= length[:, None]
    return np.stack([first, np.cross(normal, first), normal], axis=1)
