"""Sections of bolts through the elements of a shank: nodes are doubled, and may come apart.

The elements on one side keep the nodes, those on the other get copies. Where a bolt is tightened,
the copies follow as ``u_copy = u - s n``: the ends of the shank overlap by the shortening s along
the normal n, which points from the first side to the second.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.deck.content import PretensionSection
from boltjoint.structure.makers.deck.labels import Indices
from boltjoint.structure.makers.deck.mesh import Faces, Mesh

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Cut:
    """A section whose nodes are doubled.

    Attributes
    ----------
    section
        As the deck has it.
    node, copy
        Nodes on the first side, and their copies on the second.
    normal
        From the first to the second, of unit length.
    centre
        Of the area [m].
    area
        Across the normal [m2].
    element
        One of the first side.
    """

    section: PretensionSection
    node: Indices
    copy: Indices
    normal: Array
    centre: Array
    area: float
    element: int


def cut(mesh: Mesh, section: PretensionSection) -> tuple[Mesh, Cut]:
    """The mesh with the nodes of a section doubled.

    Raises
    ------
    ValueError
        If there are no elements beyond the section, or elements on both sides of it hang together
        beside it.
    """
    faces = mesh.faces(section.surface)
    name, place = section.surface.text, section.place
    vectors = faces.area_vectors(mesh.coordinate)
    size = np.linalg.norm(vectors, axis=1)
    mean = vectors.sum(axis=0)
    normal = np.array(section.normal)
    normal = normal if normal.any() else mean
    normal = normal / np.linalg.norm(normal) * (1.0 if normal @ mean >= 0 else -1.0)
    area = float(mean @ normal)
    if not area > 0.5 * size.sum():
        raise ValueError(
            f"{place}: faces of *SURFACE {name} do not look one way along the normal: give "
            "those of the elements of one side"
        )
    centre = (size @ faces.centres(mesh.coordinate)) / size.sum()
    beyond = _beyond(mesh, faces, centre, normal)
    _check_sides(mesh, faces, beyond, name, str(place))
    first = mesh.node_count
    copy_of = np.arange(first)
    copy_of[faces.nodes] = first + np.arange(len(faces.nodes))
    solids = []
    for each in mesh.solids:
        node = np.where(np.isin(each.place, beyond)[:, None], copy_of[each.node], each.node)
        solids.append(each._replace(node=node))
    parted = replace(
        mesh,
        solids=tuple(solids),
        copied=np.concatenate([mesh.copied, mesh.origin[faces.nodes]]),
    )
    element = int(faces.element[0])
    found = Cut(section, faces.nodes, copy_of[faces.nodes], normal, centre, area, element)
    return parted, found


def _beyond(mesh: Mesh, faces: Faces, centre: Array, normal: Array) -> Indices:
    """Elements at the nodes of a section that lie beyond it."""
    beyond = []
    in_section = np.zeros(mesh.node_count, bool)
    in_section[faces.nodes] = True
    for each in mesh.solids:
        touching = np.flatnonzero(in_section[each.node].any(axis=1))
        corners = each.node[touching][:, : each.kind.corners]
        height = (mesh.coordinate[corners].mean(axis=1) - centre) @ normal
        beyond.append(each.place[touching[height > 0]])
    found = np.concatenate(beyond)
    return np.setdiff1d(found, faces.element)


def _check_sides(mesh: Mesh, faces: Faces, beyond: Indices, name: str, place: str) -> None:
    every = mesh.all_faces
    in_section = np.isin(every.node, faces.nodes) & (every.node >= 0)
    touching = np.flatnonzero(in_section.any(axis=1))
    key = np.sort(every.node[touching], axis=1)
    number = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    own = np.unique(number[np.isin(touching, mesh.face_places[faces.element, faces.number])])
    is_beyond = np.isin(every.element[touching], beyond)
    on_both = np.zeros((number.max() + 1, 2), bool)
    on_both[number[is_beyond], 1] = True
    on_both[number[~is_beyond], 0] = True
    if not on_both[own].all():
        missing = int(np.count_nonzero(~on_both[own].all(axis=1)))
        raise ValueError(
            f"{place}: *SURFACE {name} has elements on one side only at {missing} of "
            f"{len(faces)} faces: a section lies within the shank"
        )
    beside = np.setdiff1d(np.flatnonzero(on_both.all(axis=1)), own)
    if beside.size:
        face = touching[np.flatnonzero(number == beside[0])[0]]
        element = mesh.deck.numbers.name(int(every.element[face]))
        raise ValueError(
            f"{place}: *SURFACE {name} parts nothing: beside it elements of both sides share "
            f"{beside.size} faces, one of {element}: a section goes all through the shank"
        )
