"""Constraints of a deck as rows, and the rigid-body motions of its bodies that they allow.

They are ties, equations, couplings, rigid bodies, sections and supports.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from boltjoint.structure.makers.deck.content import Boundary, Equation, Tie
from boltjoint.structure.makers.deck.labels import Indices
from boltjoint.structure.makers.deck.mesh import Mesh
from boltjoint.structure.makers.deck.pretension import Cut
from boltjoint.structure.makers.deck.projection import motion, project
from boltjoint.structure.makers.deck.unknowns import AXES, Rows, Unknowns

Array = NDArray[np.float64]

#: distance over the size of a master face within which nodes are tied by default
TOLERANCE = 0.05
#: and within which they are moved onto it; beyond, they keep their offset
ADJUSTED = 0.1
#: motion by which constraints are violated over that of bodies, which is rounding of coordinates
#: of six digits
_ROUNDING = 1e-6
_MOTIONS = 6


class TiedNodes(NamedTuple):
    """Nodes that a tie holds.

    Attributes
    ----------
    name
        Of the tie.
    node
        Slaves within the tolerance.
    apart
        Number of slaves beyond it.
    moved
        Largest distance by which a node was moved [m].
    distance
        Largest distance of a tied node from the faces [m].
    tolerance
        [m].
    """

    name: str
    node: Indices
    apart: int
    moved: float
    distance: float
    tolerance: float


def tie(
    mesh: Mesh,
    pair: Tie,
    tolerance: float | None,
    taken: dict[int, str],
    *,
    is_strict: bool = True,
    adjust: str = "near",
) -> tuple[Mesh, Rows, TiedNodes]:
    """Rows of a tie, and the mesh whose slaves were moved onto the faces.

    Parameters
    ----------
    mesh
        All bodies.
    pair
        Master and slave.
    tolerance
        Distance within which nodes are tied [m]; by default that of the deck, or a share of the
        size of the faces.
    taken
        Names of the ties that nodes are slaves of, to which those of this one are added.
    is_strict
        Whether slaves of another tie are refused; otherwise they stay with that.
    adjust
        Which nodes are moved onto the faces: ``near`` ones, ``all`` or ``none``; none of a tie that
        forbids it.

    Raises
    ------
    ValueError
        If no slave lies within the tolerance, or one is a slave of another tie.
    """
    faces = mesh.faces(pair.master)
    node = np.setdiff1d(mesh.nodes_of_surface(pair.slave), faces.nodes)
    twice = [index for index in node.tolist() if index in taken]
    if twice and is_strict:
        first = mesh.deck.nodes.name(int(mesh.origin[twice[0]]))
        raise ValueError(
            f"{pair.place}: *TIE {pair.name}: {first} is a slave of tie {taken[twice[0]]} already: "
            "a node follows one master"
        )
    node = np.setdiff1d(node, twice)
    size = float(np.sqrt(np.linalg.norm(faces.area_vectors(mesh.coordinate), axis=1).mean()))
    if tolerance is None:
        of_deck = pair.tolerance
        tolerance = TOLERANCE * size if of_deck is None else mesh.metre * of_deck
    projection = project(mesh.coordinate[node], faces, mesh.coordinate)
    within = projection.distance <= tolerance
    if not within.any():
        nearest = projection.distance.min(initial=np.inf) * 1e3
        raise ValueError(
            f"{pair.place}: *TIE {pair.name}: no slave lies within {1e3 * tolerance:.4g} mm of the "
            f"master: the nearest is {nearest:.4g} mm away"
        )
    node = node[within]
    projection = projection.at(within)
    farthest = {"near": ADJUSTED * size, "all": np.inf, "none": -1.0}[adjust]
    adjusted = projection.distance <= (farthest if pair.is_adjusted else -1.0)
    moved = np.zeros((mesh.node_count, AXES)) if mesh.moved is None else mesh.moved.copy()
    moved[node[adjusted]] += (projection.point - mesh.coordinate[node])[adjusted]
    mesh = replace(mesh, moved=moved)
    follows, _ = motion(mesh.coordinate[node], projection, faces, mesh.coordinate)
    columns = (AXES * node[:, None] + np.arange(AXES)).ravel()
    own = sparse.csr_array(
        (np.ones(columns.size), (np.arange(columns.size), columns)), shape=follows.shape
    )
    taken |= dict.fromkeys(node.tolist(), pair.name)
    tied = TiedNodes(
        pair.name,
        node,
        int(np.count_nonzero(~within)),
        float(projection.distance[adjusted].max(initial=0.0)),
        float(projection.distance.max(initial=0.0)),
        tolerance,
    )
    return mesh, Rows(sparse.csr_array(own - follows), columns, f"tie {pair.name}"), tied


def section_rows(cuts: Sequence[Cut], unknowns: Unknowns) -> Iterable[Rows]:
    """Rows by which copies of nodes follow with the shortening of the shank."""
    for number, cut in enumerate(cuts):
        copy, node = (unknowns.translations(part).ravel() for part in (cut.copy, cut.node))
        row = np.arange(copy.size)
        shortening = np.full(row.size, unknowns.shortening(number))
        entries = np.concatenate(
            [np.ones(row.size), -np.ones(row.size), np.tile(cut.normal, len(cut.copy))]
        )
        places = np.tile(row, 3), np.concatenate([copy, node, shortening])
        matrix = sparse.csr_array((entries, places), shape=(row.size, unknowns.size))
        yield Rows(matrix, copy, f"section {number + 1}")


def equation_rows(equations: Sequence[Equation], unknowns: Unknowns, mesh: Mesh) -> Rows:
    """Rows of equations, one for each node of sets of as many nodes."""
    row, column, entry = [], [], []
    pivot: list[int | None] = []
    for equation in equations:
        nodes = [unknowns.deck.nodes_of(term.node) for term in equation.terms]
        count = max(len(node) for node in nodes)
        if any(len(node) not in (1, count) for node in nodes):
            sizes = ", ".join(str(len(node)) for node in nodes)
            raise ValueError(
                f"{equation.place}: *EQUATION: its sets have {sizes} nodes: as many each"
            )
        for index in range(count):
            first = None
            for term, node in zip(equation.terms, nodes, strict=True):
                own = int(node[index if len(node) > 1 else 0])
                columns, factors = unknowns.terms(term.node, own, term.dof)
                row += len(columns) * [len(pivot)]
                column += columns.tolist()
                # a rotation times a length of the deck
                unit = mesh.metre if term.dof > AXES else 1.0
                entry += (unit * term.coefficient * factors).tolist()
                if first is None:
                    first = int(columns[np.argmax(abs(factors))])
            pivot.append(first)
    shape = len(pivot), unknowns.size
    matrix = sparse.coo_array((entry, (row, column)), shape=shape).tocsr()
    return Rows(matrix, np.array(pivot, np.int64), "equations")


def kinematic_rows(
    name: str, reference: int, nodes: Indices, dofs: Sequence[int], unknowns: Unknowns, mesh: Mesh
) -> Rows:
    """Rows by which nodes move rigidly with a reference node along some of x, y, z."""
    nodes = nodes[nodes != reference]
    turned = unknowns.rotations(reference)
    if turned is None:
        raise ValueError(f"{name}: its reference node has no rotations")
    axes = np.array([dof - 1 for dof in dofs])
    arm = mesh.coordinate[nodes] - mesh.coordinate[reference]
    pivot = unknowns.translations(nodes)[:, axes].ravel()
    row = np.arange(pivot.size)
    # u = u_R + theta x r, whose matrix is that of -r x theta
    cross = np.zeros((len(nodes), AXES, AXES))
    for axis in range(AXES):
        i, j = (axis + 1) % AXES, (axis + 2) % AXES
        cross[:, i, j], cross[:, j, i] = -arm[:, axis], arm[:, axis]
    of_rotation = cross[:, axes].reshape(-1, AXES)
    entries = np.concatenate([np.ones(row.size), -np.ones(row.size), of_rotation.ravel()])
    columns = np.concatenate(
        [
            pivot,
            np.tile(unknowns.translations(np.array(reference))[axes], len(nodes)),
            np.tile(turned, row.size),
        ]
    )
    rows = np.concatenate([row, row, np.repeat(row, AXES)])
    matrix = sparse.csr_array((entries, (rows, columns)), shape=(row.size, unknowns.size))
    matrix.eliminate_zeros()
    return Rows(matrix, pivot, name)


def support_rows(
    boundaries: Sequence[Boundary], unknowns: Unknowns, mesh: Mesh
) -> tuple[NDArray[np.bool_], Rows]:
    """Unknowns that are held, and rows of those that are held along other directions."""
    held = np.zeros(unknowns.size, bool)
    rows, pivots = [], []
    for boundary in boundaries:
        for node in mesh.with_copies(unknowns.deck.nodes_of(boundary.nodes)).tolist():
            for dof in range(boundary.first, boundary.last + 1):
                if dof > AXES and unknowns.rotations(node) is None:
                    continue
                columns, factors = unknowns.terms(boundary.nodes, int(mesh.origin[node]), dof)
                if node != mesh.origin[node]:
                    columns = columns + AXES * (node - int(mesh.origin[node]))
                if len(columns) == 1:
                    held[columns] = True
                else:
                    rows.append((columns, factors))
                    pivots.append(int(columns[np.argmax(abs(factors))]))
    matrix = sparse.coo_array((len(rows), unknowns.size))
    if rows:
        column = np.concatenate([columns for columns, _ in rows])
        entry = np.concatenate([factors for _, factors in rows])
        number = np.repeat(np.arange(len(rows)), [len(columns) for columns, _ in rows])
        matrix = sparse.coo_array((entry, (number, column)), shape=matrix.shape)
    return held, Rows(matrix.tocsr(), np.array(pivots, np.int64), "supports")


def bodies(mesh: Mesh) -> Indices:
    """Number of the body of each node, whose elements share nodes; -1 without, shape (nodes,)."""
    rows, columns = [], []
    for solid in mesh.solids:
        rows.append(np.repeat(solid.node[:, 0], solid.node.shape[1]))
        columns.append(solid.node.ravel())
    row, column = np.concatenate(rows), np.concatenate(columns)
    shape = (mesh.node_count, mesh.node_count)
    graph = sparse.coo_array((np.ones(len(row), np.int8), (row, column)), shape=shape)
    part = connected_components(graph.tocsr(), directed=False)[1]
    body = np.full(mesh.node_count, -1)
    body[mesh.nodes] = np.unique(part[mesh.nodes], return_inverse=True)[1].ravel()
    return body


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
    motions = sparse.coo_array((np.concatenate(entries), places), shape=shape).tocsr()
    sums = sparse.csr_array(unknowns.sums @ motions[: AXES * mesh.node_count])
    above, below = unknowns.first_sum, shape[0] - unknowns.first_sum - sums.shape[0]
    none = [sparse.csr_array((rows, shape[1])) for rows in (above, below)]
    return sparse.csc_array(motions + sparse.vstack([none[0], sums, none[1]]))


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
    for matrix in (*(part.matrix for part in rows), *others):
        own = sparse.csr_array(matrix @ sparse.diags_array(weight))
        norm = np.sqrt(np.asarray(own.multiply(own).sum(axis=1)).ravel())
        own = sparse.diags_array(1 / np.where(norm > 0, norm, 1.0)) @ own @ weighted
        gram = gram + own.T @ own
    size, vector = np.linalg.eigh(gram.toarray())
    return vector[:, size < _ROUNDING**2 * max(1.0, size[-1])]
