"""Solid elements of a deck: kinds, materials, faces, in metres."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.elements.assembly import ElementBlock
from boltjoint.structure.elements.kinds import FACE_FUNCTIONS, KINDS, ElementKind
from boltjoint.structure.elements.matrices import (
    IsotropicMaterial,
    element_volumes,
    smallest_jacobian,
)
from boltjoint.structure.elements.parent_elements import TRIANGLE_3_POINTS, TRIANGLE_7_POINTS, gauss
from boltjoint.structure.makers.deck.content import Deck, Material, Reference
from boltjoint.structure.makers.deck.labels import Indices

Array = NDArray[np.float64]


#: nodes of the largest face
MOST = 8
#: integration of a face by its number of nodes
FACE_RULES = {
    3: TRIANGLE_3_POINTS,
    4: gauss(2, 2),
    6: TRIANGLE_7_POINTS,
    8: gauss(3, 2),
}


class Solids(NamedTuple):
    """Solid elements of one kind: their places among all, and those of their nodes."""

    kind: ElementKind
    place: Indices
    node: Indices


@dataclass(frozen=True, eq=False)
class Faces:
    """Faces of elements.

    Attributes
    ----------
    element
        Places of their elements, shape (faces,).
    number
        0 for S1, shape (faces,).
    node
        Places of their nodes seen from outside, corners first, then -1, shape (faces, 8).
    """

    element: Indices
    number: Indices
    node: Indices

    def __len__(self) -> int:
        return len(self.element)

    @cached_property
    def count(self) -> Indices:
        """Number of nodes of each, shape (faces,)."""
        return np.count_nonzero(self.node >= 0, axis=1)

    @cached_property
    def nodes(self) -> Indices:
        """Places of all nodes, each once."""
        return np.unique(self.node[self.node >= 0])

    def alike(self) -> Iterator[tuple[Indices, Indices]]:
        """Faces of as many nodes, and their nodes, shapes (some,) and (some, count)."""
        for count in np.unique(self.count):
            row = np.flatnonzero(self.count == count)
            yield row, self.node[row, :count]

    def part(self, row: Indices) -> "Faces":
        """Some of them."""
        return Faces(self.element[row], self.number[row], self.node[row])

    def area_vectors(self, coordinate: Array) -> Array:
        """Areas times outward normals [m2], shape (faces, 3)."""
        vectors = np.zeros((len(self), 3))
        for row, node in self.alike():
            rule, shape = FACE_RULES[node.shape[1]], FACE_FUNCTIONS[node.shape[1]]
            slopes = np.einsum("qan,fnk->fqak", shape.slopes(rule.point), coordinate[node])
            normal = np.cross(slopes[:, :, 0], slopes[:, :, 1])
            vectors[row] = np.einsum("q,fqk->fk", rule.weight, normal)
        return vectors

    def nodal_areas(self, coordinate: Array) -> tuple[Indices, Array]:
        """Nodes of the faces, and of each the area that its shape functions weigh [m2]."""
        area = np.zeros(len(coordinate))
        for _, node in self.alike():
            rule, shape = FACE_RULES[node.shape[1]], FACE_FUNCTIONS[node.shape[1]]
            slopes = np.einsum("qan,fnk->fqak", shape.slopes(rule.point), coordinate[node])
            size = np.linalg.norm(np.cross(slopes[:, :, 0], slopes[:, :, 1]), axis=2)
            of_nodes = np.einsum("q,fq,qn->fn", rule.weight, size, shape.values(rule.point))
            np.add.at(area, node, of_nodes)
        return self.nodes, area[self.nodes]

    def centres(self, coordinate: Array) -> Array:
        """Middles of the corners, shape (faces, 3)."""
        centre = np.zeros((len(self), 3))
        for row, node in self.alike():
            corners = node[:, : 3 if node.shape[1] in (3, 6) else 4]
            centre[row] = coordinate[corners].mean(axis=1)
        return centre


@dataclass(frozen=True, eq=False)
class Mesh:
    """Solid elements of a deck with their materials.

    Attributes
    ----------
    deck
        What was read.
    metre
        Unit of lengths of the deck [m].
    solids
        By kind.
    copied
        Nodes of the deck of which the nodes after those of the deck are copies.
    moved
        Displacements by which ties put nodes onto faces [m], shape (nodes, 3); none by default.
    """

    deck: Deck
    metre: float
    solids: tuple[Solids, ...]
    copied: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    moved: Array | None = None

    @property
    def node_count(self) -> int:
        """Number of nodes with the copies."""
        return len(self.deck.nodes) + len(self.copied)

    @cached_property
    def origin(self) -> Indices:
        """Node of the deck that each is, or is a copy of."""
        return np.concatenate([np.arange(len(self.deck.nodes)), self.copied])

    @cached_property
    def coordinate(self) -> Array:
        """All nodes [m], shape (nodes, 3)."""
        place = self.metre * self.deck.coordinate[self.origin]
        return place if self.moved is None else place + self.moved

    def with_copies(self, node: Indices) -> Indices:
        """Nodes of the deck, and their copies."""
        return np.flatnonzero(np.isin(self.origin, node))

    @cached_property
    def nodes(self) -> Indices:
        """Places of the nodes of solid elements, ascending."""
        return np.unique(np.concatenate([solid.node.ravel() for solid in self.solids]))

    @property
    def volume(self) -> float:
        """[m3]."""
        return sum(float(volume.sum()) for volume in self.volumes)

    @cached_property
    def volumes(self) -> tuple[Array, ...]:
        """Of the elements of each kind [m3]."""
        return tuple(
            element_volumes(solid.kind, self.coordinate[solid.node]) for solid in self.solids
        )

    def refuse_inverted(self) -> None:
        """Refuse elements that are turned inside out, by number and line of their block.

        Raises
        ------
        ValueError
            If there are some.
        """
        for solid in self.solids:
            inverted = smallest_jacobian(solid.kind, self.coordinate[solid.node]) <= 0
            if inverted.any():
                first = int(solid.place[np.argmax(inverted)])
                block = next(block for block in self.deck.elements if first in block.place)
                raise ValueError(
                    f"{block.at}: *ELEMENT: {self.deck.numbers.name(first)} ({solid.kind.name}) is "
                    f"turned inside out, {np.count_nonzero(inverted)} of this kind in all: the "
                    "order of their nodes is wrong, or they are folded over"
                )

    @cached_property
    def all_faces(self) -> Faces:
        """All faces of all elements, shared ones twice."""
        element, number, nodes = [], [], []
        for solids in self.solids:
            for index, corner in enumerate(solids.kind.faces):
                node = np.full((len(solids.place), MOST), -1)
                node[:, : len(corner)] = solids.node[:, corner]
                element.append(solids.place)
                number.append(np.full(len(solids.place), index))
                nodes.append(node)
        return Faces(np.concatenate(element), np.concatenate(number), np.concatenate(nodes))

    @cached_property
    def outer_faces(self) -> Faces:
        """Faces that no two elements share."""
        faces = self.all_faces
        key = np.sort(faces.node, axis=1)
        _, inverse, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
        return faces.part(np.flatnonzero(count[inverse.ravel()] == 1))

    @cached_property
    def face_places(self) -> Indices:
        """Row of each face S1 to S6 in ``all_faces``, -1 for none, shape (elements, 6)."""
        faces = self.all_faces
        place = np.full((len(self.deck.numbers), 6), -1)
        place[faces.element, faces.number] = np.arange(len(faces))
        return place

    def faces(self, reference: Reference) -> Faces:
        """Faces of a surface.

        Raises
        ------
        ValueError
            If the surface is one of nodes, is empty, or has a face that its element has not.
        """
        surface = self.deck.surface(reference)
        if surface.of_nodes:
            raise ValueError(
                f"{surface.place}: *SURFACE {surface.name} is one of nodes: faces of elements are "
                f"needed at {reference.place}, by TYPE=ELEMENT"
            )
        rows = [np.zeros(0, np.int64)]
        for piece in surface.pieces:
            element = self.deck.elements_of(piece.reference)
            if piece.face is None:
                outer = self.outer_faces
                of_set = outer.part(np.flatnonzero(np.isin(outer.element, element)))
                rows.append(self.face_places[of_set.element, of_set.number])
                continue
            row = self.face_places[element, piece.face - 1]
            if np.any(row < 0):
                missing = self.deck.numbers.name(int(element[np.argmin(row)]))
                raise ValueError(
                    f"{piece.reference.place}: *SURFACE {surface.name}: {missing} has no face "
                    f"S{piece.face}"
                )
            rows.append(row)
        row = np.concatenate(rows)
        if not row.size:
            raise ValueError(f"{surface.place}: *SURFACE {surface.name} has no faces")
        return self.all_faces.part(row[np.sort(np.unique(row, return_index=True)[1])])

    def nodes_of_surface(self, reference: Reference) -> Indices:
        """Nodes of a surface of faces or of nodes."""
        surface = self.deck.surface(reference)
        if not surface.of_nodes:
            return self.faces(reference).nodes
        nodes = [self.deck.nodes_of(piece.reference) for piece in surface.pieces]
        return np.unique(np.concatenate([*nodes, np.zeros(0, np.int64)]))

    @cached_property
    def materials(self) -> tuple[list[Material], Indices]:
        """Materials of sections, and of each element its number among them, -1 for none."""
        names: list[str] = []
        number = np.full(len(self.deck.numbers), -1)
        for section in self.deck.sections:
            key = section.material.upper()
            if key not in self.deck.materials:
                raise ValueError(
                    f"{section.elements.place}: *SOLID SECTION: there is no *MATERIAL "
                    f"{section.material}"
                )
            if key not in names:
                names.append(key)
            number[self.deck.elements_of(section.elements)] = names.index(key)
        return [self.deck.materials[name] for name in names], number

    def blocks(self, pascal: float, kilogram_per_m3: float) -> tuple[ElementBlock, ...]:
        """Elements with their materials, in Pa and kg/m3, from units of the deck.

        Raises
        ------
        ValueError
            If an element has no material, or a material no elasticity or density.
        """
        materials, number = self.materials
        blocks = []
        for solids in self.solids:
            own = number[solids.place]
            if np.any(own < 0):
                missing = self.deck.numbers.name(int(solids.place[np.argmin(own)]))
                raise ValueError(
                    f"{self.deck.file}: {missing} ({solids.kind.name}) has no material: give "
                    "*SOLID SECTION for its set"
                )
            values = np.zeros((3, len(own)))
            for index in np.unique(own):
                values[:, own == index] = _constants(materials[index])[:, None]
            values *= np.array([pascal, 1.0, kilogram_per_m3])[:, None]
            material = IsotropicMaterial(*values)
            label = self.deck.numbers.label[solids.place]
            blocks.append(ElementBlock(solids.kind, solids.node, material, label))
        return tuple(blocks)


def _constants(material: Material) -> Array:
    if material.youngs_modulus is None:
        raise ValueError(f"{material.place}: *MATERIAL {material.name} has no *ELASTIC")
    if material.density is None:
        raise ValueError(
            f"{material.place}: *MATERIAL {material.name} has no *DENSITY: give materials: "
            f"[{{name: {material.name}, density_kg_per_m3: ...}}]"
        )
    return np.array([material.youngs_modulus, material.poissons_ratio, material.density])


def mesh_of(deck: Deck, metre: float = 1.0) -> Mesh:
    """The solid elements of a deck.

    Raises
    ------
    ValueError
        If there are none.
    """
    by_kind: dict[str, list] = {}
    for elements in deck.elements:
        if elements.kind in KINDS:
            by_kind.setdefault(elements.kind, []).append(elements)
    if not by_kind:
        raise ValueError(f"{deck.file} has no solid elements: C3D4 to C3D20")
    solids = tuple(
        Solids(
            KINDS[kind],
            np.concatenate([block.place for block in blocks]),
            np.concatenate([block.node for block in blocks]),
        )
        for kind, blocks in by_kind.items()
    )
    return Mesh(deck, metre, solids)
