"""Unknowns of a deck, and the matrix T of ``v = T q`` by which constraints eliminate some.

Each row may prefer an unknown, as that of a node that is tied. Rows that prefer none, or one that
another row or a support has, are reduced by those that have theirs and get the unknowns that
pivoting finds: constraints may so depend on each other in chains. One sparse LU solves for all.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import qr
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from boltjoint.structure.makers.deck.content import Axes, Deck, Reference
from boltjoint.structure.makers.deck.labels import Indices

Array = NDArray[np.float64]

AXES = 3


@dataclass
class Unknowns:
    """Columns of all constraints, stiffness and mass.

    First the displacements along x, y, z of all nodes, copies at sections last; then the rotations
    of nodes that have some; then sums over groups of nodes (``distributing``); then the shortening
    of each section.

    Attributes
    ----------
    deck
        What was read.
    nodes
        Number of nodes with the copies.
    turning
        Nodes that have rotations.
    sections
        Nodes whose first displacement is the shortening of a section, in their order.
    sums
        Sums by displacements of nodes, shape (sums, 3 nodes).
    """

    deck: Deck
    nodes: int
    turning: Indices
    sections: list[int]
    sums: sparse.csr_array

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.shortening(len(self.sections))

    def translations(self, node: Indices) -> Indices:
        """Unknowns of nodes along x, y, z, shape (nodes, 3)."""
        return AXES * np.asarray(node)[..., None] + np.arange(AXES)

    def rotations(self, node: int) -> Indices | None:
        """Unknowns of the rotation of a node, None where it has none."""
        place = np.searchsorted(self.turning, node)
        if place == len(self.turning) or self.turning[place] != node:
            return None
        return AXES * (self.nodes + place) + np.arange(AXES)

    @property
    def first_sum(self) -> int:
        """The unknown of the first sum."""
        return AXES * (self.nodes + len(self.turning))

    def shortening(self, section: int) -> int:
        """The unknown of a section."""
        return self.first_sum + self.sums.shape[0] + section

    def terms(self, reference: Reference, node: int, dof: int) -> tuple[Indices, Array]:
        """Unknowns and factors of a displacement, 1 to 3, or rotation, 4 to 6, of a node.

        Raises
        ------
        ValueError
            If the node has no such displacement.
        """
        if node in self.sections:
            if dof != 1:
                raise ValueError(
                    f"{reference.place}: {self.deck.nodes.name(node)} is that of a pre-tension "
                    "section: it has displacement 1 alone"
                )
            return np.array([self.shortening(self.sections.index(node))]), np.ones(1)
        columns = self.translations(np.array(node))
        if dof > AXES:
            rotations = self.rotations(node)
            if rotations is None:
                raise ValueError(
                    f"{reference.place}: {self.deck.nodes.name(node)} has no rotation {dof}: no "
                    "coupling, rigid body or beam turns it"
                )
            columns = rotations
        direction = self.directions(node)[(dof - 1) % AXES]
        acting = np.flatnonzero(direction)
        return columns[acting], direction[acting]

    def directions(self, node: int) -> Array:
        """Directions in which displacements of a node are given, as rows."""
        axes = self._axes.get(node)
        if axes is None:
            return np.eye(AXES)
        first, second = np.split(np.array(axes.points), 2)
        if axes.kind == "R":
            x = first / np.linalg.norm(first)
            z = np.cross(first, second)
        else:
            z = second - first
            arm = self.deck.coordinate[node] - first
            x = arm - (arm @ z) * z / (z @ z)
            if not np.linalg.norm(x) > 0:
                raise ValueError(
                    f"{axes.nodes.place}: *TRANSFORM: {self.deck.nodes.name(node)} lies on the axis"
                )
            x /= np.linalg.norm(x)
        z /= np.linalg.norm(z)
        return np.stack([x, np.cross(z, x), z])

    @cached_property
    def _axes(self) -> dict[int, Axes]:
        return {
            int(node): axes for axes in self.deck.axes for node in self.deck.nodes_of(axes.nodes)
        }


#: columns that are solved for together
_BLOCK = 512
#: pivot over the largest of its rows, below which a row repeats others
_DEPENDENT = 1e-9
#: entry of T beyond which constraints cannot be told from contradictions
_LARGEST = 1e6
#: entry of T over the largest that is rounding
_ROUNDING = 1e-14


class Rows(NamedTuple):
    """Constraints of one kind.

    Attributes
    ----------
    matrix
        G, shape (rows, unknowns).
    pivot
        The unknown that each row is best solved for, -1 where it does not matter.
    name
        For messages.
    """

    matrix: sparse.csr_array
    pivot: Indices
    name: str


@dataclass(frozen=True, eq=False)
class Elimination:
    """What is left by constraints.

    Attributes
    ----------
    transformation
        T, shape (unknowns, free unknowns).
    free
        Unknowns that are left, ascending.
    repeated
        Number of rows that others imply.
    """

    transformation: sparse.csc_array
    free: Indices
    repeated: int


def eliminate(rows: list[Rows], held: NDArray[np.bool_], kept: NDArray[np.bool_]) -> Elimination:
    """Solve constraints.

    Parameters
    ----------
    rows
        Of all kinds.
    held
        Unknowns that are zero, shape (unknowns,).
    kept
        Unknowns that must not be solved for, as the shortening of a bolt, shape (unknowns,).

    Raises
    ------
    ValueError
        If constraints contradict each other, or go in a circle.
    """
    size = held.size
    G = sparse.vstack([*(part.matrix for part in rows), sparse.csr_array((0, size))], format="csr")
    pivot = np.concatenate([*(part.pivot for part in rows), np.zeros(0, np.int64)])
    G = sparse.csr_array(G @ sparse.diags_array(np.where(held, 0.0, 1.0)))
    G.eliminate_zeros()
    norm = np.sqrt(np.bincount(_row_of_entries(G), G.data**2, minlength=G.shape[0]))
    acting = norm > 0
    G.data /= norm[_row_of_entries(G)]
    pivot = np.where((pivot >= 0) & (held | kept)[pivot], -1, pivot)
    # of two rows that prefer the same unknown the first has it
    first = np.zeros(len(pivot), bool)
    first[np.unique(pivot, return_index=True)[1]] = True
    settled = np.flatnonzero(acting & first & (pivot >= 0))
    if settled.size:
        weight = abs(np.asarray(G[settled, pivot[settled]])).ravel()
        settled = settled[weight > _DEPENDENT]
    order, solved = settled, pivot[settled]
    waiting = np.setdiff1d(np.flatnonzero(acting), settled)
    repeated = 0
    if waiting.size:
        T = _solve(G[order], solved, held, size)
        more, columns, repeated = _pivots(sparse.csr_array(G[waiting] @ T), kept)
        order = np.concatenate([order, waiting[more]])
        solved = np.concatenate([solved, columns])
    T = _solve(G[order], solved, held, size)
    is_free = ~held
    is_free[solved] = False
    free = np.flatnonzero(is_free)
    if abs(T.data).max(initial=0.0) > _LARGEST:
        raise ValueError(
            "constraints contradict each other: a displacement would be more than "
            f"{_LARGEST:g} times that of the nodes it follows"
        )
    return Elimination(sparse.csc_array(T[:, free]), free, repeated)


def _row_of_entries(G: sparse.csr_array) -> Indices:
    return np.repeat(np.arange(G.shape[0]), np.diff(G.indptr))


def _solve(
    G: sparse.csr_array, solved: Indices, held: NDArray[np.bool_], size: int
) -> sparse.csc_array:
    """All unknowns from those that are neither solved for nor held, shape (unknowns, unknowns)."""
    is_free = ~held
    is_free[solved] = False
    one = sparse.diags_array(is_free.astype(float), format="csc")
    if not solved.size:
        return sparse.csc_array(one)
    columns = sparse.csc_array(G)
    own = sparse.csc_array(columns[:, solved])
    others = sparse.csc_array(columns @ one)
    touched = np.flatnonzero(np.diff(others.indptr))
    try:
        factors = splu(own)
    except RuntimeError:
        raise ValueError("constraints go in a circle: one follows from another and back") from None
    parts = []
    for start in range(0, len(touched), _BLOCK):
        block = others[:, touched[start : start + _BLOCK]]
        parts.append(sparse.csc_array(_without_rounding(-factors.solve(block.toarray()))))
    solution = sparse.hstack(parts, format="coo") if parts else sparse.coo_array((len(solved), 0))
    entries = solution.data, (solved[solution.coords[0]], touched[solution.coords[1]])
    return sparse.csc_array(one + sparse.coo_array(entries, shape=(size, size)).tocsc())


def _without_rounding(values: Array) -> Array:
    values[abs(values) <= _ROUNDING * abs(values).max(initial=0.0)] = 0.0
    return values


def _pivots(G: sparse.csr_array, kept: NDArray[np.bool_]) -> tuple[Indices, Indices, int]:
    """Rows that others do not imply, the unknowns they are solved for, and how many others are."""
    G = G.copy()
    G.data[abs(G.data) < _DEPENDENT] = 0.0
    G.eliminate_zeros()
    pattern = abs(G) @ abs(G).T
    parts, part = connected_components(pattern, directed=False)
    rows, columns, repeated = [], [], 0
    for number in range(parts):
        row = np.flatnonzero(part == number)
        block = sparse.csc_array(G[row])
        column = np.flatnonzero(np.diff(block.indptr))
        column = column[~kept[column]]
        if not column.size:
            repeated += len(row)
            continue
        dense = block[:, column].toarray()
        # independent rows first, then of these the unknowns that weigh most
        triangle, row_order = qr(dense.T, mode="r", pivoting=True)
        size = abs(np.diag(triangle))
        rank = int(np.count_nonzero(size > _DEPENDENT * size.max(initial=0.0)))
        chosen = np.sort(row_order[:rank])
        repeated += len(row) - rank
        pivot = qr(dense[chosen], mode="r", pivoting=True)[1][:rank]
        rows.append(row[chosen])
        columns.append(column[pivot])
    none = np.zeros(0, np.int64)
    return np.concatenate([*rows, none]), np.concatenate([*columns, none]), repeated
