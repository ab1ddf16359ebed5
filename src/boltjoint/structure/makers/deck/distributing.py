"""Distributing couplings: a reference node moves with the mean of many.

Where equations or a bolt hold such a mean, one of its nodes follows from all others, and the
stiffness would be full among them. The mean of many nodes is therefore taken in two steps, whatever
holds it: sums over groups of neighbours are unknowns of their own, each of which takes the place of
a displacement in its group, and the mean is one of sums.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import qr, svd

from boltjoint.structure.makers.deck.content import Coupling, Deck
from boltjoint.structure.makers.deck.labels import Indices
from boltjoint.structure.makers.deck.mesh import Mesh
from boltjoint.structure.makers.deck.unknowns import AXES, Rows, Unknowns

Array = NDArray[np.float64]

#: second moment of the nodes of a coupling over the largest, below which they lie on a line
_ON_A_LINE = 1e-9
#: nodes of a coupling above which it is taken in groups
MANY = 500
#: nodes of a group: up to half of the root of their number, or up to so many
_GROUP = 24
#: part of a group in the mean over the largest, below which it is rounding
_ROUNDING = 1e-9


class Group(NamedTuple):
    """Neighbours that are summed: their places in the coupling, and the factors of the sums.

    ``factors`` have the shape (sums, nodes, 3), orthonormal.
    """

    place: Indices
    factors: Array


@dataclass(frozen=True, eq=False)
class DistributingCoupling:
    """A reference node that moves with the mean of nodes.

    Attributes
    ----------
    name
        For messages.
    reference
        The reference node.
    nodes
        Those it moves with, shape (nodes,).
    mean
        Displacement, and rotation where it has one, by displacements of the nodes: shape
        (3 or 6, nodes, 3).
    groups
        Where there are many nodes; else none.
    """

    name: str
    reference: int
    nodes: Indices
    mean: Array
    groups: tuple[Group, ...]

    def rows(self, unknowns: Unknowns, first: int) -> Rows:
        """Constraints, with sums over groups from the unknown ``first`` on."""
        of_reference = unknowns.translations(np.array(self.reference))
        rotations = unknowns.rotations(self.reference)
        if rotations is not None:
            of_reference = np.concatenate([of_reference, rotations])
        own = _one_each(of_reference, unknowns.size)
        mean = self.mean.reshape(len(self.mean), -1)
        if not self.groups:
            at_once = sparse.csr_array(
                own - sparse.csr_array(mean) @ self._displacements(unknowns.size)
            )
            return Rows(at_once, of_reference, self.name)
        sums = _one_each(first + np.arange(self._by_place.shape[0]), unknowns.size)
        # sums are orthonormal, and hold all of the mean
        by_sums = sparse.csr_array(mean @ self._by_place.T) @ sums
        matrix = sparse.vstack([own - by_sums, sums - self.sums(unknowns.size)], format="csr")
        pivots = [of_reference]
        for place, factors in self.groups:
            # of the nodes those that the sums depend on most
            chosen = qr(factors.reshape(len(factors), -1), mode="r", pivoting=True)[1]
            members = unknowns.translations(self.nodes[place])
            pivots.append(members.ravel()[chosen[: len(factors)]])
        return Rows(matrix, np.concatenate(pivots), self.name)

    def sums(self, unknowns: int) -> sparse.csr_array:
        """Sums over groups by displacements, shape (sums, unknowns)."""
        return sparse.csr_array(self._by_place @ self._displacements(unknowns))

    @cached_property
    def _by_place(self) -> sparse.csr_array:
        """Sums over groups by displacements of the places in the coupling, (sums, 3 nodes)."""
        blocks = []
        for place, factors in self.groups:
            columns = AXES * place[:, None] + np.arange(AXES)
            rows, values = np.arange(len(factors)), factors.reshape(len(factors), -1)
            at = np.repeat(rows, columns.size), np.tile(columns.ravel(), len(rows))
            shape = len(rows), AXES * len(self.nodes)
            blocks.append(sparse.coo_array((values.ravel(), at), shape=shape))
        none = sparse.csr_array((0, AXES * len(self.nodes)))
        return sparse.csr_array(sparse.vstack([none, *blocks], format="csr"))

    def _displacements(self, unknowns: int) -> sparse.csr_array:
        """Displacements of the places by the unknowns, shape (3 nodes, unknowns)."""
        return _one_each((AXES * self.nodes[:, None] + np.arange(AXES)).ravel(), unknowns)


def distributing_couplings(
    deck: Deck, mesh: Mesh, turning: Indices
) -> dict[int, DistributingCoupling]:
    """Those of a deck by the number of their first coupling; some nodes have a rotation."""
    joined: dict[int, tuple[str, int, list[Indices], list[Array]]] = {}
    of_elements: dict[int, int] = {}
    for number, coupling in enumerate(deck.couplings):
        if coupling.kind == "kinematic":
            continue
        name = f"{coupling.place}: *COUPLING {coupling.name or number + 1}"
        nodes, weight = coupled_nodes(mesh, coupling)
        key = number
        if coupling.of_surface:
            reference = deck.node_of(coupling.reference)
        else:
            # CalculiX: the node of the element DCOUP3D, lines of one block together
            reference = node_of_element(deck, coupling)
            key = of_elements.setdefault(reference, number)
        _, _, more_nodes, more_weights = joined.setdefault(key, (name, reference, [], []))
        more_nodes.append(nodes)
        more_weights.append(weight)
    couplings = {}
    for key, (name, reference, parts, weights) in joined.items():
        nodes, weight = np.concatenate(parts), np.concatenate(weights)
        place, at = mesh.coordinate[nodes], mesh.coordinate[reference]
        mean = _mean(name, at, place, weight / weight.sum(), turns=reference in turning)
        groups = tuple(_groups(mean, place))
        couplings[key] = DistributingCoupling(name, reference, nodes, mean, groups)
    return couplings


def coupled_nodes(mesh: Mesh, coupling: Coupling) -> tuple[Indices, Array]:
    """Nodes of a coupling with their weights: areas of a surface, or those given."""
    if not coupling.of_surface:
        node = mesh.deck.nodes_of(coupling.nodes)
        return node, np.full(len(node), coupling.weights[0] if coupling.weights else 1.0)
    if mesh.deck.surface(coupling.nodes).of_nodes:
        node = mesh.nodes_of_surface(coupling.nodes)
        return node, np.ones(len(node))
    return mesh.faces(coupling.nodes).nodal_areas(mesh.coordinate)


def node_of_element(deck: Deck, coupling: Coupling) -> int:
    """The node of the element DCOUP3D of a coupling; a ``ValueError`` without one."""
    place = deck.elements_of(coupling.reference)
    for elements in deck.elements:
        if elements.kind == "DCOUP3D":
            node = elements.node[np.isin(elements.place, place)]
            if node.size:
                return int(node[0, 0])
    raise ValueError(
        f"{coupling.place}: *DISTRIBUTING COUPLING: set {coupling.reference.text} has no element "
        "DCOUP3D"
    )


def _mean(name: str, reference: Array, place: Array, weight: Array, *, turns: bool) -> Array:
    """Mean motion of nodes at the place of a reference node, shape (3 or 6, nodes, 3).

    Its rotation is ``T^-1 sum w r x u`` with the second moment T of the nodes about their middle;
    where the reference node has none, its displacement is the mean one wherever it lies.
    """
    translation = np.einsum("n,ij->inj", weight, np.eye(AXES))
    if not turns:
        return translation
    middle = weight @ place
    arm = place - middle
    second = np.einsum("n,nk,nl->kl", weight, arm, arm)
    moment = np.trace(second) * np.eye(AXES) - second
    size = np.linalg.eigvalsh(moment)
    if not size[0] > _ON_A_LINE * size[-1]:
        raise ValueError(f"{name}: its nodes lie on a line: they have no mean rotation")
    # r x u by axis, node and displacement
    turning = np.cross(arm[:, None], np.eye(AXES)).transpose(2, 0, 1)
    rotation = np.einsum("ik,knj,n->inj", np.linalg.inv(moment), turning, weight)
    translation = translation + np.cross(rotation, reference - middle, axis=0)
    return np.concatenate([translation, rotation])


def _groups(mean: Array, place: Array) -> Iterator[Group]:
    """Groups of neighbours of many nodes, whose sums the mean is made of; none of few."""
    if len(place) <= MANY:
        return
    most = max(_GROUP, ceil(sqrt(len(place)) / 2))
    size = np.linalg.norm(mean, axis=(1, 2))
    waiting = [np.arange(len(place))]
    while waiting:
        members = waiting.pop()
        if len(members) > most:
            longest = np.argmax(np.ptp(place[members], axis=0))
            order = members[np.argsort(place[members, longest], kind="stable")]
            waiting += [*np.array_split(order, 2)]
            continue
        part = mean[:, members] / size[:, None, None]
        _, values, factors = svd(part.reshape(len(mean), -1), full_matrices=False)
        factors = factors[values > _ROUNDING * values[0]]
        if not len(factors):
            # nodes without weight
            continue
        yield Group(members, factors.reshape(-1, len(members), AXES))


def _one_each(column: Indices, size: int) -> sparse.csr_array:
    """Rows with a one in a column each, shape (columns, size)."""
    entries = np.ones(len(column)), (np.arange(len(column)), column)
    return sparse.coo_array(entries, shape=(len(column), size)).tocsr()
