"""Bolts of a deck: sections that double the nodes of shanks, beams, and loads on reference nodes.

The elements on one side keep the nodes, those on the other get copies. Where a bolt is tightened,
the copies follow as ``u_copy = u - s n``: the ends of the shank overlap by the shortening s along
the normal n, which points from the first side to the second.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from boltjoint.structure.makers.deck.content import (
    Deck,
    FacePiece,
    Load,
    PretensionSection,
    Reference,
    SurfaceLines,
)
from boltjoint.structure.makers.deck.labels import WHOLE, Indices
from boltjoint.structure.makers.deck.lines import Place
from boltjoint.structure.makers.deck.mesh import Faces, Mesh, mesh_of

if TYPE_CHECKING:
    from boltjoint.config.deck import DeckBolt


Array = NDArray[np.float64]

#: forces of a bolt that differ by more do not balance
_APART = 1e-6
#: height of nodes above a plane, over the size of their face, up to which they lie in it
_IN_PLANE = 1e-3

_MM = 1e-3


class SectionBolt(NamedTuple):
    """A bolt that a section tightens: its number among the sections of the deck."""

    name: str
    section: int


class CouplingBolt(NamedTuple):
    """A bolt between two reference nodes, which opposite forces along a direction load.

    ``node`` are both, ``direction`` that of the force on the first at a tension of 1.
    """

    name: str
    node: Indices
    direction: Array


DeckBolts = list[SectionBolt | CouplingBolt]


def bolts_of(deck: Deck, wanted: "Sequence[DeckBolt] | None") -> DeckBolts:
    """The bolts of a deck.

    Parameters
    ----------
    deck
        What was read.
    wanted
        Which of them in which order, all of them by default.

    Raises
    ------
    ValueError
        If there are none, or none of a name.
    """
    declared: DeckBolts = [
        SectionBolt(section.name, number) for number, section in enumerate(deck.pretension)
    ]
    if wanted is None:
        declared += _loaded_pairs(deck)
        if not declared:
            raise ValueError(
                f"{deck.file} has no bolts: no *PRE-TENSION SECTION, and no opposite forces on "
                "two reference nodes that *EQUATION joins"
            )
        return declared
    bolts: DeckBolts = []
    for described in wanted:
        section = described.section if described.plane is None else _surface_of(described)
        if section is not None:
            names = {bolt.name.upper(): bolt for bolt in declared}
            if section.upper() not in names:
                there = ", ".join(bolt.name for bolt in declared) or "none"
                raise ValueError(
                    f"{deck.file} has no *PRE-TENSION SECTION of {section}; there are: {there}"
                )
            bolts.append(names[section.upper()]._replace(name=described.name))
        else:
            couplings = described.couplings or ()
            nodes = np.array([_reference_node(deck, name) for name in couplings])
            pair = next((one for one in _loaded_pairs(deck) if set(one.node) == set(nodes)), None)
            if pair is None:
                raise ValueError(
                    f"{deck.file}: couplings {', '.join(couplings)} of bolt {described.name} have "
                    "no opposite forces by *CLOAD, which tell its direction"
                )
            bolts.append(pair._replace(name=described.name))
    return bolts


def loads_of(deck: Deck, bolts: DeckBolts) -> Array | None:
    """Tensions that the deck gives its bolts, in its units; None where it gives not all."""
    tensions = []
    for bolt in bolts:
        if isinstance(bolt, SectionBolt):
            node = deck.node_of(deck.pretension[bolt.section].node)
            forces = [load.force for load in deck.loads if node in deck.nodes_of(load.nodes)]
            tensions.append(next((abs(force) for force in forces if force), 0.0))
        else:
            force = _force_on(deck, int(bolt.node[0]))
            tensions.append(float(np.linalg.norm(force)))
    return np.array(tensions) if all(tensions) else None


def lengths_given(deck: Deck, bolts: DeckBolts) -> list[str]:
    """Names of bolts that the deck shortens by a length instead of a force."""
    names = []
    for bolt in bolts:
        if isinstance(bolt, SectionBolt):
            node = deck.node_of(deck.pretension[bolt.section].node)
            if any(
                boundary.value and node in deck.nodes_of(boundary.nodes)
                for boundary in deck.boundaries
            ):
                names.append(bolt.name)
    return names


def _reference_node(deck: Deck, name: str) -> int:
    """The reference node of a coupling of this name, or the node itself, or that of a set."""
    for coupling in deck.couplings:
        if coupling.of_surface and name.upper() in (
            coupling.name.upper(),
            coupling.reference.text.upper(),
        ):
            return deck.node_of(coupling.reference)
    there = (
        ", ".join(coupling.name or coupling.reference.text for coupling in deck.couplings) or "none"
    )
    raise ValueError(f"{deck.file} has no *COUPLING {name}; there are: {there}")


def _loaded_pairs(deck: Deck) -> list[CouplingBolt]:
    """Pairs of reference nodes that equations join and opposite forces load."""
    reference = {
        deck.node_of(coupling.reference): coupling.name or coupling.reference.text
        for coupling in deck.couplings
        if coupling.of_surface
    }
    joined: dict[int, set[int]] = {}
    for equation in deck.equations:
        nodes = {int(node) for term in equation.terms for node in deck.nodes_of(term.node)}
        own = nodes & reference.keys()
        for node in own:
            joined.setdefault(node, set()).update(own)
    pairs: list[CouplingBolt] = []
    for first in reference:
        others = joined.get(first, set()) - {first}
        if len(others) != 1 or (second := next(iter(others))) in [p.node[0] for p in pairs]:
            continue
        force, opposite = _force_on(deck, first), _force_on(deck, second)
        size = float(np.linalg.norm(force))
        if size and np.linalg.norm(force + opposite) <= _APART * size:
            both = np.array([first, second])
            pairs.append(CouplingBolt(reference[first], both, force / size))
    return pairs


def _force_on(deck: Deck, node: int) -> Array:
    """Force on a node in the first step that has one, along x, y, z."""
    own: list[Load] = [load for load in deck.loads if node in deck.nodes_of(load.nodes)]
    force = np.zeros(3)
    for load in own:
        if load.step == own[0].step and load.dof <= 3:
            force[load.dof - 1] += load.force
    return force


def with_planes(mesh: Mesh, wanted: "Sequence[DeckBolt]") -> Mesh:
    """The mesh of a deck, which gets a section for each bolt that is described by a plane.

    Parameters
    ----------
    mesh
        Of the deck as it was read.
    wanted
        The bolts.

    Raises
    ------
    ValueError
        If no faces lie in a plane.
    """
    deck, of_planes = mesh.deck, [bolt for bolt in wanted if bolt.plane is not None]
    for bolt in of_planes:
        name, place = _surface_of(bolt), Place(deck.file, 0)
        point, normal, faces = _faces_in_plane(mesh, bolt)
        pieces = []
        for element, number in zip(faces.element.tolist(), faces.number.tolist(), strict=True):
            label = deck.numbers.name(element).removeprefix(deck.numbers.what).strip()
            pieces.append(FacePiece(Reference(label, WHOLE, place), number + 1))
        deck.surfaces[name.upper()] = SurfaceLines(name, place, False, pieces)
        own = int(deck.nodes.label.max()) + 1
        deck.nodes.add(WHOLE, np.array([own]))
        deck.coordinate = np.vstack([deck.coordinate, point / mesh.metre])
        node, surface = (Reference(text, WHOLE, place) for text in (str(own), name))
        x, y, z = normal.tolist()
        deck.pretension.append(PretensionSection(node, surface, None, (x, y, z), place))
    return mesh_of(deck, mesh.metre) if of_planes else mesh


def _surface_of(bolt: "DeckBolt") -> str:
    """Name of the surface of a bolt that is described by a plane."""
    return f"plane of {bolt.name}"


def _faces_in_plane(mesh: Mesh, bolt: "DeckBolt") -> tuple[Array, Array, Faces]:
    """Point [m] and normal of the plane of a bolt, and faces in it that look along the normal."""
    if bolt.plane is None:
        raise ValueError(f"bolt {bolt.name} has no plane")
    point, normal = _MM * np.array(bolt.plane.point_mm), np.array(bolt.plane.normal)
    normal = normal / np.linalg.norm(normal)
    height = abs((mesh.coordinate - point) @ normal)
    every = mesh.all_faces
    farthest = np.where(every.node < 0, 0.0, height[every.node]).max(axis=1)
    near = np.flatnonzero(farthest <= _IN_PLANE * np.ptp(mesh.coordinate, axis=0).max())
    faces = every.part(near)
    vectors = faces.area_vectors(mesh.coordinate)
    in_plane = farthest[near] <= _IN_PLANE * np.sqrt(np.linalg.norm(vectors, axis=1))
    faces = faces.part(np.flatnonzero(in_plane & (vectors @ normal > 0)))
    if not len(faces):
        where = ", ".join(f"{x:g}" for x in bolt.plane.point_mm)
        raise ValueError(
            f"{mesh.deck.file}: no faces of elements lie in the plane of bolt {bolt.name} through "
            f"{where} mm: mesh its shank with such a plane"
        )
    row, column = np.nonzero(faces.node >= 0)
    shape = len(faces), mesh.node_count
    at = sparse.csr_array((np.ones(len(row)), (row, faces.node[row, column])), shape=shape)
    _, part = connected_components(at @ at.T, directed=False)
    apart = np.linalg.norm(faces.centres(mesh.coordinate) - point, axis=1)
    return point, normal, faces.part(np.flatnonzero(part == part[np.argmin(apart)]))


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
    if section.surface is None:
        raise ValueError(f"{section.place}: *PRE-TENSION SECTION of {section.name} has no surface")
    faces = mesh.faces(section.surface)
    name, place = section.name, section.place
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
    for solid in mesh.solids:
        node = np.where(np.isin(solid.place, beyond)[:, None], copy_of[solid.node], solid.node)
        solids.append(solid._replace(node=node))
    parted = replace(
        mesh,
        solids=tuple(solids),
        copied=np.concatenate([mesh.copied, mesh.origin[faces.nodes]]),
    )
    element = int(faces.element[0])
    section_cut = Cut(section, faces.nodes, copy_of[faces.nodes], normal, centre, area, element)
    return parted, section_cut


def _beyond(mesh: Mesh, faces: Faces, centre: Array, normal: Array) -> Indices:
    """Elements at the nodes of a section that lie beyond it."""
    beyond = []
    in_section = np.zeros(mesh.node_count, bool)
    in_section[faces.nodes] = True
    for solid in mesh.solids:
        touching = np.flatnonzero(in_section[solid.node].any(axis=1))
        corners = solid.node[touching][:, : solid.kind.corners]
        height = (mesh.coordinate[corners].mean(axis=1) - centre) @ normal
        beyond.append(solid.place[touching[height > 0]])
    element = np.concatenate(beyond)
    return np.setdiff1d(element, faces.element)


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
