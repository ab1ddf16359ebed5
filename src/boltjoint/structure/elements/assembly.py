"""Stiffness and mass of bodies of solid elements of one or more kinds."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint import checks
from boltjoint.structure.elements.kinds import ElementKind
from boltjoint.structure.elements.matrices import (
    ElementOptions,
    IsotropicMaterial,
    element_matrices,
    element_volumes,
    refuse_inverted,
)

Array = NDArray[np.float64]

#: entries of the stiffness of elements that are in memory together
_ENTRIES = 2**22


@dataclass(frozen=True, eq=False)
class ElementBlock:
    """Elements of one kind in a body.

    Attributes
    ----------
    kind
        Of all of them.
    connectivity
        Places of their nodes, shape (elements, nodes).
    material
        Of all of them, or of each.
    label
        Their numbers in messages, shape (elements,); their places by default.
    """

    kind: ElementKind
    connectivity: NDArray[np.integer]
    material: IsotropicMaterial
    label: NDArray[np.integer] | None = None

    def __post_init__(self) -> None:
        """Refuse nodes and materials that do not fit."""
        checks.instance("kind", self.kind, ElementKind)
        checks.instance("material", self.material, IsotropicMaterial)
        shape = ("elements", self.kind.nodes)
        connectivity = checks.indices("connectivity", self.connectivity, shape)
        object.__setattr__(self, "connectivity", connectivity)
        self.material.of_elements(len(connectivity))
        if self.label is not None:
            label = checks.indices("label", self.label, (len(connectivity),))
            object.__setattr__(self, "label", label)

    def pieces(self) -> Iterator["ElementBlock"]:
        """The block in pieces of as many elements as are worked on at a time."""
        size = max(1, _ENTRIES // (3 * self.kind.nodes) ** 2)
        E, nu, density = self.material.of_elements(len(self.connectivity))
        label = np.arange(len(self.connectivity)) if self.label is None else self.label
        for start in range(0, len(self.connectivity), size):
            own = slice(start, start + size)
            material = IsotropicMaterial(E[own], nu[own], density[own])
            yield ElementBlock(self.kind, self.connectivity[own], material, label[own])


def assemble(
    coordinate: Array, blocks: Sequence[ElementBlock], options: ElementOptions | None = None
) -> tuple[sparse.csc_array, sparse.csc_array]:
    """Stiffness and mass of a body.

    Parameters
    ----------
    coordinate
        Nodes, shape (nodes, 3) [m].
    blocks
        Its elements.
    options
        How they are integrated.

    Returns
    -------
    tuple
        K [N/m] and M [kg], shape (3 * nodes, 3 * nodes), symmetric; the unknown 3 i + a is the
        displacement of node i along axis a. Nodes without elements have neither.

    Raises
    ------
    ValueError
        If shapes make no sense, a node does not exist, or an element is turned inside out.
    """
    coordinate, blocks = _body(coordinate, blocks)
    nodes = len(coordinate)
    pair = _node_pairs(nodes, blocks)
    stiffness, mass = np.zeros((pair.size, 9)), np.zeros((pair.size, 1))
    for block in blocks:
        for piece in block.pieces():
            own, corners = piece.connectivity, coordinate[piece.connectivity]
            refuse_inverted(piece.kind, corners, piece.label)
            K, M = element_matrices(piece.kind, corners, piece.material, options)
            count = piece.kind.nodes
            K = K.reshape(-1, count, 3, count, 3).transpose(0, 1, 3, 2, 4)
            place = np.searchsorted(pair, own[:, :, None] * nodes + own[:, None, :]).ravel()
            _add(place, (stiffness, K.reshape(-1, 9)), (mass, M.reshape(-1, 1)))
    row, column = np.divmod(pair, nodes)
    pointer = np.searchsorted(row, np.arange(nodes + 1)).astype(np.int32)
    shape = (3 * nodes, 3 * nodes)
    column = column.astype(np.int32)
    K = sparse.bsr_array((stiffness.reshape(-1, 3, 3), column, pointer), shape=shape)
    M = sparse.csr_array((mass[:, 0], column, pointer), shape=(nodes, nodes))
    # rows are columns of symmetric matrices
    return K.tocsc(), sparse.csc_array(sparse.kron(M, sparse.eye_array(3), format="csc"))


def volume(coordinate: Array, blocks: Sequence[ElementBlock]) -> float:
    """Volume of a body [m3].

    Parameters
    ----------
    coordinate, blocks
        As for ``assemble``.
    """
    return sum(float(volume.sum()) for volume, _ in _volumes(coordinate, blocks))


def mass(coordinate: Array, blocks: Sequence[ElementBlock]) -> float:
    """Mass of a body [kg].

    Parameters
    ----------
    coordinate, blocks
        As for ``assemble``.
    """
    return sum(float(volume @ density) for volume, density in _volumes(coordinate, blocks))


def _volumes(coordinate: Array, blocks: Sequence[ElementBlock]) -> Iterator[tuple[Array, Array]]:
    """Volumes and densities of elements, piece by piece."""
    coordinate, blocks = _body(coordinate, blocks)
    for block in blocks:
        for piece in block.pieces():
            volumes = element_volumes(piece.kind, coordinate[piece.connectivity])
            yield volumes, np.asarray(piece.material.density, dtype=np.float64)


def _body(
    coordinate: Array, blocks: Sequence[ElementBlock]
) -> tuple[Array, Sequence[ElementBlock]]:
    """Nodes, and blocks of them."""
    coordinate = checks.array("coordinate", coordinate, ("nodes", 3))
    checks.sequence("blocks", blocks, ElementBlock)
    for i, block in enumerate(blocks):
        checks.indices(f"connectivity of blocks[{i}]", block.connectivity, count=len(coordinate))
    if not any(len(block.connectivity) for block in blocks):
        raise ValueError("blocks are empty: a body has at least one element")
    return coordinate, blocks


def _node_pairs(nodes: int, blocks: Sequence[ElementBlock]) -> NDArray[np.int64]:
    """Numbers row * nodes + column of the pairs of nodes that share an element, ascending."""
    neighbours = sparse.csr_array((nodes, nodes), dtype=np.int8)
    for block in blocks:
        elements, count = block.connectivity.shape
        entries = np.ones(block.connectivity.size, dtype=np.int8)
        pointer = np.arange(elements + 1) * count
        of_elements = sparse.csr_array(
            (entries, block.connectivity.ravel(), pointer), shape=(elements, nodes)
        )
        neighbours = neighbours + (of_elements.T @ of_elements).astype(bool)
    neighbours = sparse.csr_array(neighbours)
    neighbours.sort_indices()
    row = np.repeat(np.arange(nodes), np.diff(neighbours.indptr))
    return row * nodes + neighbours.indices.astype(np.int64)


def _add(place: NDArray[np.int64], *sums: tuple[Array, Array]) -> None:
    """Add rows to the rows of a sum at their places, many of which are the same."""
    order = np.argsort(place, kind="stable")
    place = place[order]
    start = np.flatnonzero(np.concatenate([[True], place[1:] != place[:-1]]))
    for total, rows in sums:
        total[place[start]] += np.add.reduceat(rows[order], start, axis=0)
