"""Rigid-body motions of the bodies of a deck by geometry: which of them constraints allow."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from boltjoint.structure.makers.deck.labels import Indices
from boltjoint.structure.makers.deck.mesh import Mesh
from boltjoint.structure.makers.deck.unknowns import AXES, Rows, Unknowns

Array = NDArray[np.float64]

#: motion by which constraints are violated over that of bodies, which is rounding of coordinates
#: of six digits
_ROUNDING = 1e-6
_MOTIONS = 6


def bodies(mesh: Mesh) -> Indices:
    """Number of the body of each node, whose elements share nodes; -1 without, shape (nodes,)."""
    rows, columns = [], []
    for each in mesh.solids:
        rows.append(np.repeat(each.node[:, 0], each.node.shape[1]))
        columns.append(each.node.ravel())
    row, column = np.concatenate(rows), np.concatenate(columns)
    shape = (mesh.node_count, mesh.node_count)
    graph = sparse.coo_array((np.ones(len(row), np.int8), (row, column)), shape=shape)
    part = connected_components(graph.tocsr(), directed=False)[1]
    found = np.full(mesh.node_count, -1)
    found[mesh.nodes] = np.unique(part[mesh.nodes], return_inverse=True)[1].ravel()
    return found


def motions_of_bodies(mesh: Mesh, unknowns: Unknowns, body: Indices) -> sparse.csc_array:
    """Motions of each body and reference node alone, shape (unknowns, motions).

    Six each: translations of 1, and rotations about the middle of all by 1 over the size of all.
    """
    place = mesh.coordinate
    middle = place[mesh.nodes].mean(axis=0)
    size = np.ptp(place[mesh.nodes], axis=0).max()
    number = body.copy()
    alone = np.setdiff1d(unknowns.turning, mesh.nodes)
    number[alone] = body.max() + 1 + np.arange(len(alone))
    node = np.flatnonzero(number >= 0)
    arm = (place[node] - middle) / size
    turned = number[unknowns.turning]
    rows, columns, entries = [], [], []
    own = unknowns.translations(node)
    rotations = AXES * (mesh.node_count + np.arange(len(turned)))
    for axis in range(AXES):
        i, j = (axis + 1) % AXES, (axis + 2) % AXES
        rows += [own[:, axis], own[:, j], own[:, i], rotations + axis]
        turning = _MOTIONS * number[node] + AXES + axis
        columns += [_MOTIONS * number[node] + axis, turning, turning]
        columns.append(_MOTIONS * turned + AXES + axis)
        entries += [np.ones(len(node)), arm[:, i], -arm[:, j], np.full(len(turned), 1 / size)]
    shape = (unknowns.size, _MOTIONS * (number.max() + 1))
    places = np.concatenate(rows), np.concatenate(columns)
    return sparse.coo_array((np.concatenate(entries), places), shape=shape).tocsc()


def allowed(
    motions: sparse.csc_array,
    rows: list[Rows],
    held: NDArray[np.bool_],
    *others: sparse.csr_array,
) -> Array:
    """Factors of motions that violate no constraint, orthonormal, shape (motions, allowed).

    Parameters
    ----------
    motions
        As from ``motions_of_bodies``.
    rows, held
        Constraints, and unknowns that are zero.
    others
        Further rows that must stay zero, as of closed contact.
    """
    # rotations weigh as the displacements they make, and each row as much as any other
    weight = abs(motions).max(axis=1).toarray().ravel()
    weighted = sparse.diags_array(1 / np.where(weight > 0, weight, 1.0)) @ motions
    gram = weighted[held].T @ weighted[held]
    for each in (*(part.matrix for part in rows), *others):
        own = sparse.csr_array(each @ sparse.diags_array(weight))
        norm = np.sqrt(np.asarray(own.multiply(own).sum(axis=1)).ravel())
        own = sparse.diags_array(1 / np.where(norm > 0, norm, 1.0)) @ own @ weighted
        gram = gram + own.T @ own
    size, vector = np.linalg.eigh(gram.toarray())
    return vector[:, size < _ROUNDING**2 * max(1.0, size[-1])]
