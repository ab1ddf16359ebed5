"""Points projected on faces of elements, and motion of the faces there.

A point at the offset d from its projection moves with the face as the neighbourhood of the face
does: ``u = sum N_i u_i + d^a sum N_i,a u_i - h a^a (n . sum N_i,a u_i)``, with d^a along the
tangents, h along the normal n and a^a the reciprocal tangents. Rigid-body motion of the face is
rigid-body motion of the point, whatever its offset.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from boltjoint.structure.elements.kinds import FACE_FUNCTIONS
from boltjoint.structure.makers.deck.labels import Indices
from boltjoint.structure.makers.deck.mesh import Faces

Array = NDArray[np.float64]

#: faces near each point of which the nearest is found
_NEAR = 24
_ITERATIONS = 12
#: overhang over the edge of a face, in parent coordinates, that is rounding
_OVER = 1e-9


class Projection(NamedTuple):
    """Nearest points on faces.

    Attributes
    ----------
    face
        Rows of the faces, shape (points,).
    parent
        Parent coordinates there, shape (points, 2).
    point
        The nearest points [m], shape (points, 3).
    distance
        From the points [m], shape (points,).
    """

    face: Indices
    parent: Array
    point: Array
    distance: Array

    def at(self, some: NDArray[np.bool_]) -> "Projection":
        """That of some of the points, which the mask (points,) tells."""
        return Projection(self.face[some], self.parent[some], self.point[some], self.distance[some])


def project(point: Array, faces: Faces, coordinate: Array) -> Projection:
    """Nearest points on faces.

    Parameters
    ----------
    point
        Shape (points, 3) [m].
    faces
        At least one.
    coordinate
        All nodes [m], shape (nodes, 3).
    """
    row, sample = _samples(faces, coordinate)
    near = min(_NEAR, len(sample))
    candidate = row[cKDTree(sample).query(point, k=near)[1].reshape(len(point), near)]
    pair = np.repeat(np.arange(len(point)), near), candidate.ravel()
    pair = tuple(np.unique(np.stack(pair), axis=1))
    parent, nearest = np.zeros((len(pair[0]), 2)), np.zeros((len(pair[0]), 3))
    for count in np.unique(faces.count):
        of_count = np.flatnonzero(faces.count[pair[1]] == count)
        corner = coordinate[faces.node[pair[1][of_count], :count]]
        parent[of_count], nearest[of_count] = _nearest(point[pair[0][of_count]], corner)
    distance = np.linalg.norm(point[pair[0]] - nearest, axis=1)
    order = np.lexsort((distance, pair[0]))
    first = order[np.unique(pair[0][order], return_index=True)[1]]
    return Projection(pair[1][first], parent[first], nearest[first], distance[first])


def motion(
    point: Array, projection: Projection, faces: Faces, coordinate: Array
) -> tuple[sparse.csr_array, Array]:
    """Displacement of points that move with faces, from that of all nodes.

    Parameters
    ----------
    point
        Which may have an offset from their projections, shape (points, 3) [m].
    found, faces, coordinate
        As from and for ``project``.

    Returns
    -------
    tuple
        Rows along x, y, z, point by point, shape (3 * points, 3 * nodes), and the outward normals
        of the faces, shape (points, 3).
    """
    normals = np.zeros((len(point), 3))
    rows, columns, entries = [], [], []
    for count in np.unique(faces.count[projection.face]):
        own = np.flatnonzero(faces.count[projection.face] == count)
        node = faces.node[projection.face[own], :count]
        shape = FACE_FUNCTIONS[count]
        value, slope = shape.values(projection.parent[own]), shape.slopes(projection.parent[own])
        tangent = slope @ coordinate[node]
        normal = np.cross(tangent[:, 0], tangent[:, 1])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        reciprocal = np.linalg.solve(tangent @ tangent.transpose(0, 2, 1), tangent)
        offset = point[own] - projection.point[own]
        along = np.einsum("pak,pk->pa", reciprocal, offset)
        height = np.einsum("pk,pk->p", normal, offset)
        scalar = value + np.einsum("pa,pan->pn", along, slope)
        turned = np.einsum("p,pak,pan->pnk", height, reciprocal, slope)
        block = scalar[:, :, None, None] * np.eye(3) - turned[..., None] * normal[:, None, None, :]
        shape_of = block.shape
        rows.append(np.broadcast_to(3 * own[:, None, None, None] + np.arange(3)[:, None], shape_of))
        columns.append(np.broadcast_to(3 * node[:, :, None, None] + np.arange(3), shape_of))
        entries.append(block)
        normals[own] = normal
    flat = [np.concatenate([part.ravel() for part in parts]) for parts in (entries, rows, columns)]
    matrix = sparse.coo_array(
        (flat[0], (flat[1], flat[2])), shape=(3 * len(point), 3 * len(coordinate))
    ).tocsr()
    matrix.eliminate_zeros()
    return matrix, normals


def _samples(faces: Faces, coordinate: Array) -> tuple[Indices, Array]:
    """Middles and nodes of faces, by which near ones are found."""
    rows, points = [np.arange(len(faces))], [faces.centres(coordinate)]
    for row, node in faces.alike():
        rows.append(np.repeat(row, node.shape[1]))
        points.append(coordinate[node].reshape(-1, 3))
    return np.concatenate(rows), np.concatenate(points)


def _nearest(point: Array, node: Array) -> tuple[Array, Array]:
    """Parent coordinates and place on one face each, by Gauss-Newton steps or on an edge."""
    shape = FACE_FUNCTIONS[node.shape[1]]
    corner = shape.corner
    parent = np.tile(corner.mean(axis=0), (len(point), 1))
    reach = np.ptp(corner, axis=0).max()
    for _ in range(_ITERATIONS):
        place = np.einsum("pn,pnk->pk", shape.values(parent), node)
        tangent = shape.slopes(parent) @ node
        metric = tangent @ tangent.transpose(0, 2, 1)
        slope = np.einsum("pak,pk->pa", tangent, point - place)
        step = np.linalg.solve(metric, slope[..., None])[..., 0]
        parent = np.clip(parent + step, corner.min(axis=0) - reach, corner.max(axis=0) + reach)
    outside = ~_is_inside(parent, corner)
    place = np.einsum("pn,pnk->pk", shape.values(parent), node)
    if outside.any():
        parent[outside], place[outside] = _on_edges(point[outside], node[outside], corner)
    return parent, place


def _is_inside(parent: Array, corner: Array) -> NDArray[np.bool_]:
    if len(corner) == 3:
        return (parent.min(axis=1) > -_OVER) & (parent.sum(axis=1) < 1 + _OVER)
    return abs(parent).max(axis=1) < 1 + _OVER


def _on_edges(point: Array, node: Array, corner: Array) -> tuple[Array, Array]:
    """Nearest points on the edges, which are straight here."""
    start = np.arange(len(corner))
    end = np.roll(start, -1)
    first, along = node[:, start], node[:, end] - node[:, start]
    share = np.einsum("pek,pek->pe", point[:, None] - first, along)
    share = np.clip(share / np.einsum("pek,pek->pe", along, along), 0, 1)
    place = first + share[..., None] * along
    nearest = np.linalg.norm(place - point[:, None], axis=2).argmin(axis=1)
    part = share[np.arange(len(point)), nearest][:, None]
    parent = corner[start[nearest]] + part * (corner[end[nearest]] - corner[start[nearest]])
    # of curved edges the point of the parent, not that of the chord
    shape = FACE_FUNCTIONS[node.shape[1]]
    return parent, np.einsum("pn,pnk->pk", shape.values(parent), node)
