"""Faces of a contact surface: flat pieces to cut, and places on them.

Faces have 3, 4, 6 or 8 nodes, corners first, seen from outside the body. For polygons a face is
its corners, or of a curved one with middle nodes four pieces of it; shape functions are those of
the face itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.structure.elements.kinds import FACE_FUNCTIONS
from boltjoint.structure.elements.parent_elements import ShapeFunctions

Array = NDArray[np.float64]

#: distance of a middle node from the middle of its edge, over the edge, that is rounding
_STRAIGHT = 1e-9

#: Newton iterations for the place of a point on a face; after a step of this length, in parent
#: coordinates, what is left is its square
_ITERATIONS, _LAST_STEP = 20, 1e-8

#: parent coordinates of the pieces of curved faces, corners of triangles repeated, by their nodes
_PIECES = {
    6: (
        ((0, 0), (0.5, 0), (0, 0.5), (0, 0.5)),
        ((0.5, 0), (1, 0), (0.5, 0.5), (0.5, 0.5)),
        ((0, 0.5), (0.5, 0.5), (0, 1), (0, 1)),
        ((0.5, 0), (0.5, 0.5), (0, 0.5), (0, 0.5)),
    ),
    8: (
        ((-1, -1), (0, -1), (0, 0), (-1, 0)),
        ((0, -1), (1, -1), (1, 0), (0, 0)),
        ((0, 0), (1, 0), (1, 1), (0, 1)),
        ((-1, 0), (0, 0), (0, 1), (-1, 1)),
    ),
}


@dataclass(frozen=True, eq=False)
class FaceGroup:
    """Faces of one number of nodes.

    ``connectivity`` (faces, nodes); ``coordinate`` of the nodes (faces, nodes, 3) [m].
    """

    connectivity: NDArray[np.int64]
    coordinate: Array

    @property
    def functions(self) -> ShapeFunctions:
        """Shape functions of the faces."""
        return FACE_FUNCTIONS[self.connectivity.shape[1]]

    @property
    def is_linear(self) -> bool:
        """Whether all nodes are corners."""
        return not self.functions.edges

    @cached_property
    def is_affine(self) -> NDArray[np.bool_]:
        """Whether edges are straight and opposite ones parallel, of each face, shape (faces,)."""
        slopes = np.einsum(
            "qia,fak->fqik", self.functions.slopes(self.functions.corner), self.coordinate
        )
        spread = abs(slopes - slopes.mean(axis=1, keepdims=True)).max(axis=(1, 2, 3))
        return spread < _STRAIGHT * abs(slopes).max(axis=(1, 2, 3))

    def polygons(self) -> tuple[NDArray[np.int64], Array]:
        """Faces that polygons belong to, and their vertices, shape (polygons, 4, 3)."""
        functions = self.functions
        corners = functions.corner[[0, 1, 2, -1]]
        whole = np.arange(len(self.connectivity))
        owners, vertices = [], []
        if not self.is_linear:
            ends = self.coordinate[:, np.array(functions.edges)]
            middle = self.coordinate[:, len(functions.corner) :]
            apart = np.linalg.norm(middle - ends.mean(axis=2), axis=2)
            length = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
            is_curved = np.any(apart > _STRAIGHT * length, axis=1)
            for piece in _PIECES[self.connectivity.shape[1]]:
                owners.append(whole[is_curved])
                vertices.append(functions.values(np.array(piece)) @ self.coordinate[is_curved])
            whole = whole[~is_curved]
        owners.append(whole)
        vertices.append(functions.values(corners) @ self.coordinate[whole])
        return np.concatenate(owners), np.concatenate(vertices)

    def places(self, face: NDArray[np.int64], point: Array, tangents: Array) -> Array:
        """Parent coordinates where lines normal to planes meet faces, shape (points, 2).

        Parameters
        ----------
        face
            Of each point, shape (points,).
        point
            A point of the line, shape (points, 3) [m].
        tangents
            Two directions of the plane, shape (points, 2, 3).

        Raises
        ------
        ValueError
            If a face is folded over.
        """
        coordinate = self.coordinate[face]
        place = np.broadcast_to(self.functions.corner.mean(axis=0), (len(face), 2)).copy()
        for _ in range(_ITERATIONS):
            x = np.einsum("pa,pak->pk", self.functions.values(place), coordinate)
            apart = np.einsum("pik,pk->ip", tangents, x - point)
            slopes = np.einsum("pja,pak->pjk", self.functions.slopes(place), coordinate)
            J = np.einsum("pik,pjk->ijp", tangents, slopes)
            determinant = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
            step = np.stack(
                [
                    (J[1, 1] * apart[0] - J[0, 1] * apart[1]) / determinant,
                    (J[0, 0] * apart[1] - J[1, 0] * apart[0]) / determinant,
                ],
                axis=1,
            )
            place -= step
            if not step.size or abs(step).max() < _LAST_STEP:
                return place
        worst = face[np.argmax(np.nan_to_num(abs(step).max(axis=1), nan=np.inf))]
        middle = ", ".join(f"{x:.6g}" for x in self.coordinate[worst].mean(axis=0))
        raise ValueError(f"the face at ({middle}) m is too distorted: no place on it is unique")

    def normals(self, face: NDArray[np.int64], place: Array) -> Array:
        """Normals of faces at places, outward, area over that of the parent, (points, 3) [m2]."""
        slopes = np.einsum("pja,pak->pjk", self.functions.slopes(place), self.coordinate[face])
        return np.cross(slopes[:, 0], slopes[:, 1])


@dataclass(frozen=True, eq=False)
class Polygons:
    """Flat pieces of all faces of a surface.

    ``group`` and ``face`` (polygons,): the face each belongs to; ``vertex`` (polygons, 4, 3) [m].
    """

    group: NDArray[np.int64]
    face: NDArray[np.int64]
    vertex: Array

    @cached_property
    def centre(self) -> Array:
        """Means of the vertices [m], shape (polygons, 3)."""
        return self.vertex.mean(axis=1)

    @cached_property
    def normal(self) -> Array:
        """Unit normals, outward, shape (polygons, 3)."""
        vertex = self.vertex
        normal = np.cross(vertex[:, 2] - vertex[:, 0], vertex[:, 3] - vertex[:, 1])
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    @cached_property
    def area(self) -> Array:
        """Areas in the plane of each [m2], shape (polygons,)."""
        vertex = self.vertex
        cross = np.cross(vertex[:, 2] - vertex[:, 0], vertex[:, 3] - vertex[:, 1])
        return np.linalg.norm(cross, axis=1) / 2

    @cached_property
    def radius(self) -> Array:
        """Largest distances of vertices from the centre [m], shape (polygons,)."""
        return np.linalg.norm(self.vertex - self.centre[:, None], axis=2).max(axis=1)

    @cached_property
    def tangents(self) -> Array:
        """Two unit vectors in the plane of each, shape (polygons, 2, 3)."""
        normal = self.normal
        least = np.eye(3)[np.argmin(abs(normal), axis=1)]
        first = np.cross(normal, least)
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        return np.stack([first, np.cross(normal, first)], axis=1)


def face_groups(
    name: str, coordinate: Array, sides: Sequence[NDArray[np.integer]]
) -> list[FaceGroup]:
    """Faces of a surface by their numbers of nodes.

    Parameters
    ----------
    name
        Of the surface, in messages.
    coordinate
        Nodes of the body, shape (nodes, 3) [m].
    sides
        Nodes of the faces, an array (faces, nodes) of each number of nodes: 3, 4, 6 or 8.

    Raises
    ------
    ValueError
        If there are none, they have another number of nodes, or a node does not exist.
    """
    checks.sequence(name, sides)
    groups = []
    for i, side in enumerate(sides):
        faces = checks.indices(f"{name}[{i}]", side, ("faces", "nodes"), count=len(coordinate))
        if faces.shape[1] not in FACE_FUNCTIONS:
            allowed = ", ".join(str(count) for count in FACE_FUNCTIONS)
            raise ValueError(f"{name}[{i}] has faces of {faces.shape[1]} nodes: allowed: {allowed}")
        if len(faces):
            groups.append(FaceGroup(faces, coordinate[faces]))
    if not groups:
        raise ValueError(f"{name} is empty: a surface has at least one face")
    return groups


def polygons_of(groups: Sequence[FaceGroup]) -> Polygons:
    """Flat pieces of the faces of all groups."""
    parts = [group.polygons() for group in groups]
    number = [np.full(len(face), i) for i, (face, _) in enumerate(parts)]
    faces, vertices = zip(*parts, strict=True)
    return Polygons(np.concatenate(number), np.concatenate(faces), np.concatenate(vertices))
