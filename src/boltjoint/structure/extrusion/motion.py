"""Degrees of freedom of bodies whose shanks are cut, and their mirror images.

They are the displacements of the nodes that are neither held nor on the head's side of a pretension
section, and after them the shortening of each shank.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from boltjoint.structure.model import Reflection

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

_AXES = np.arange(3)

#: mirror images apart by more than this share of the width are none
_APART = 1e-9


def dofs(node: NDArray[np.integer]) -> Labels:
    """Displacements of nodes along x, y, z, one node after another, shape (3 * nodes,)."""
    return (3 * np.asarray(node)[:, None] + _AXES).ravel()


def free_motion(
    nodes: int, section: Labels, bolt_of_pair: Labels, held: Labels, bolts: int
) -> sparse.csc_array:
    """The matrix T of ``u = T q`` that holds supports and joins the pretension sections.

    A node on the nut's side of a section is free, the node facing it on the head's side follows::

        u_head = u_nut - shortening e_z

    Parameters
    ----------
    nodes
        Number of nodes.
    section
        Nodes on the nut's and on the head's side of all sections, shape (pairs, 2).
    bolt_of_pair
        Bolt of each of these pairs, shape (pairs,).
    held
        Nodes that do not move.
    bolts
        Number of bolts whose shortening is an unknown, the last ones of q; with 0 the sections stay
        closed.

    Returns
    -------
    csc_array
        T, shape (3 * nodes, unknowns).
    """
    nut_side, head_side = section.T
    leader = np.arange(nodes)
    leader[head_side] = nut_side
    is_free = np.ones(nodes, dtype=bool)
    is_free[head_side] = False
    is_free[held] = False

    column = np.cumsum(is_free) - 1
    moving = np.flatnonzero(is_free[leader])
    row = dofs(moving)
    unknown = dofs(column[leader[moving]])
    value = np.ones(row.size)
    size = 3 * np.count_nonzero(is_free)
    if bolts:
        row = np.concatenate([row, 3 * head_side + 2])
        unknown = np.concatenate([unknown, size + bolt_of_pair])
        value = np.concatenate([value, np.full(head_side.size, -1.0)])
        size += bolts
    return sparse.csc_array((value, (row, unknown)), shape=(3 * nodes, size))


def reflection(
    coordinate: Array,
    body: Labels,
    T: sparse.csc_array,
    bolt_position: Array,
    side_a: Labels,
) -> Reflection | None:
    """The reflection at the plane of x and z, None where the mesh is not symmetric.

    Parameters
    ----------
    coordinate
        Nodes [m], shape (nodes, 3).
    body
        As from ``bodies_of_nodes``, shape (nodes,).
    T
        As from ``free_motion``, with the shortening of each bolt.
    bolt_position
        Points on the axes of the bolts [m], shape (bolts, 3).
    side_a
        Nodes of side A of the contact, shape (pairs,).
    """
    node_image = _images(coordinate, body, np.ptp(coordinate[:, 1]))
    bolt_image = _images(bolt_position, np.zeros(len(bolt_position), int), np.ptp(coordinate[:, 1]))
    if node_image is None or bolt_image is None:
        return None
    moving = T.shape[1] - len(bolt_position)
    # every free displacement follows one unknown; held displacements are not used
    displacement = T.indices[T.indptr[:moving]]
    node, axis = np.divmod(displacement, 3)
    follows = np.zeros(T.shape[0], dtype=np.int64)
    of_moving = T[:, :moving]
    follows[of_moving.indices] = np.repeat(np.arange(moving), np.diff(of_moving.indptr))
    image = np.append(follows[3 * node_image[node] + axis], moving + bolt_image)
    sign = np.append(np.where(axis == 1, -1.0, 1.0), np.ones(len(bolt_position)))
    pair_of_node = np.zeros(len(node_image), dtype=np.int64)
    pair_of_node[side_a] = np.arange(len(side_a))
    return Reflection(image, sign, pair_of_node[node_image[side_a]])


def bodies_of_nodes(nodes: int, connectivity: Labels, part: Labels, head_side: Labels) -> Labels:
    """Numbers that tell nodes at one place apart, shape (nodes,).

    They belong to different bodies, or to the two sides of a pretension section.

    Parameters
    ----------
    nodes
        Number of nodes.
    connectivity, part
        Nodes and part of each element, shapes (elements, corners) and (elements,).
    head_side
        Nodes on the head's side of the sections.
    """
    body = np.full(nodes, part.max() + 1)
    np.minimum.at(body, connectivity, part[:, None])
    body[head_side] += part.max() + 1
    return body


def _images(place: Array, body: Labels, width: float) -> Labels | None:
    """The place of the same body on the other side of each, None where one has none."""
    image = np.empty(len(place), dtype=np.int64)
    for number in np.unique(body):
        own = np.flatnonzero(body == number)
        distance, nearest = cKDTree(place[own]).query(place[own] * [1, -1, 1])
        if distance.max() > _APART * width:
            return None
        image[own] = own[nearest]
    return image
