"""Contact of a deck: points of its pairs of surfaces, on which rigid-body motion has no slip."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.structure.contact_points import DIRECTIONS, ContactPoints
from boltjoint.structure.makers.deck.content import ContactPair, Deck, Reference
from boltjoint.structure.makers.deck.lines import Place
from boltjoint.structure.makers.deck.mesh import Faces, Mesh
from boltjoint.structure.nonmatching_faces.weighted_points import WeightedPoints, weighted_points

if TYPE_CHECKING:
    from boltjoint.config.deck import DeckContact

Array = NDArray[np.float64]

_MM = 1e-3
#: rotation by 1 that slips by less, over the size of the face, is rounding
_ROUNDING = 1e-13
#: distance of nodes over the size of all bodies, below which they coincide
_COINCIDENT = 1e-9


def faces_of_contact(mesh: Mesh, interface: "DeckContact") -> tuple[Faces, Faces]:
    """Faces of both surfaces.

    Raises
    ------
    ValueError
        If there is no such surface, or both have the same nodes.
    """
    place = Place(mesh.deck.file, 0)
    sides = []
    for name in interface.surfaces:
        if name.upper() not in mesh.deck.surfaces:
            there = ", ".join(surface.name for surface in mesh.deck.surfaces.values()) or "none"
            raise ValueError(f"{mesh.deck.file} has no *SURFACE {name}; there are: {there}")
        at = mesh.deck.surfaces[name.upper()].place
        sides.append(mesh.faces(Reference(name, "", at or place)))
    apart = np.setdiff1d(sides[0].nodes, sides[1].nodes)
    if not apart.size:
        raise ValueError(
            f"{mesh.deck.file}: surfaces {' and '.join(interface.surfaces)} share all nodes: a "
            "node cannot meet itself"
        )
    return sides[0], sides[1]


def is_named(pair: tuple[str, str], contact: "Sequence[DeckContact]") -> bool:
    """Whether a pair of surfaces has friction, whichever is named first."""
    names = frozenset(name.upper() for name in pair)
    return any(
        names == frozenset(name.upper() for name in interface.surfaces) for interface in contact
    )


def tied_pairs(contact: "Sequence[DeckContact]", deck: Deck) -> list[ContactPair]:
    """Contact pairs of a deck that are not named, and so are tied.

    Raises
    ------
    ValueError
        If the deck ties one itself.
    """
    pairs = [
        pair for pair in deck.contact if not is_named((pair.slave.text, pair.master.text), contact)
    ]
    tied = {frozenset((tie.slave.text.upper(), tie.master.text.upper())): tie for tie in deck.ties}
    for pair in pairs:
        if tie := tied.get(frozenset((pair.slave.text.upper(), pair.master.text.upper()))):
            raise ValueError(
                f"{pair.place}: *CONTACT PAIR: {pair.slave.text} and {pair.master.text} are tied "
                f"by *TIE {tie.name} at {tie.place} already"
            )
    return pairs


def points_of_contact(
    mesh: Mesh, displacement: sparse.csc_array, contact: "Sequence[DeckContact]"
) -> tuple[ContactPoints, dict[str, WeightedPoints]]:
    """Contact points of all pairs, and those of each by its name.

    Parameters
    ----------
    mesh
        All bodies.
    displacement
        Of all nodes along x, y, z, shape (3 * nodes, dofs).
    contact
        Pairs of surfaces.

    Raises
    ------
    ValueError
        If surfaces do not exist, do not meet, or look away from each other.
    """
    parts, met = [], {}
    for interface in contact:
        points = weighted(mesh, interface)
        met[interface.name] = points
        own_points = points.contact_points(
            surface=interface.name,
            penalty=interface.penalty_N_per_m3,
            friction_coefficient=interface.friction_coefficient,
        )
        rows = _without_slip_in_rotation(own_points.relative, mesh.coordinate)
        parts.append((own_points, sparse.csr_array(rows @ displacement)))
    return (
        ContactPoints(
            sparse.csr_array(sparse.vstack([rows for _, rows in parts])),
            **{
                name: np.concatenate([getattr(part, name) for part, _ in parts])
                for name in (
                    *("position", "frame", "area", "surface", "gap", "penalty"),
                    "friction_coefficient",
                )
            },
        ),
        met,
    )


def weighted(mesh: Mesh, interface: "DeckContact") -> WeightedPoints:
    """Points of a pair, with signed gaps."""
    one, other = faces_of_contact(mesh, interface)
    sides = [[node for _, node in faces.alike()] for faces in (one, other)]
    weighting = "face" if interface.points == "faces" else "dual"
    gap = None if interface.largest_gap_mm is None else _MM * interface.largest_gap_mm
    along = np.array(interface.first_tangent)
    try:
        points = weighted_points(
            mesh.coordinate, sides[0], sides[1], along, weighting=weighting, largest_gap=gap
        )
        return _of_both_sides(points)
    except ValueError as error:
        names = " and ".join(interface.surfaces)
        if "do not meet" in str(error) and _look_away(mesh, one, other):
            raise ValueError(
                f"{mesh.deck.file}: surfaces {names} look away from each other: their faces must "
                "be those between both bodies"
            ) from None
        raise ValueError(f"{mesh.deck.file}: surfaces {names}: {error}") from None


def _of_both_sides(points: WeightedPoints) -> WeightedPoints:
    """Points at which the sides may move apart: not those of nodes that both share."""
    kept = np.flatnonzero(np.diff(points.rows.indptr))
    return WeightedPoints(
        points.rows[kept],
        *(getattr(points, name)[kept] for name in ("position", "frame", "area", "gap")),
    )


def _look_away(mesh: Mesh, one: Faces, other: Faces) -> bool:
    """Whether the normals of two surfaces do not point at each other."""
    first, second = (faces.area_vectors(mesh.coordinate).sum(axis=0) for faces in (one, other))
    return bool(first @ second >= 0)


def _without_slip_in_rotation(rows: sparse.csr_array, coordinate: Array) -> sparse.csr_array:
    """Rows of relative displacement that rigid-body rotation does not change.

    Where surfaces stand apart, a rotation moves two opposite points differently, though nothing
    slips. The least change of the factors of the nodes takes that away.
    """
    columns, factors, counts = [], [], []
    coincident = _COINCIDENT * np.ptp(coordinate, axis=0).max()
    for start, end in zip(rows.indptr[:-1], rows.indptr[1:], strict=True):
        column, factor = rows.indices[start:end], rows.data[start:end]
        slip = factor @ _rigid(column, coordinate, coincident)
        if abs(slip).max() > _ROUNDING:
            node = np.unique(column // DIRECTIONS)
            every = (DIRECTIONS * node[:, None] + np.arange(DIRECTIONS)).ravel()
            widened = np.zeros(len(every))
            widened[np.searchsorted(every, column)] = factor
            motions = _rigid(every, coordinate, coincident)
            change = np.linalg.lstsq(motions.T @ motions, motions.T @ widened, rcond=1e-12)[0]
            column, factor = every, widened - motions @ change
        columns.append(column)
        factors.append(factor)
        counts.append(len(column))
    pointer = np.concatenate([[0], np.cumsum(counts)])
    return sparse.csr_array((np.concatenate(factors), np.concatenate(columns), pointer), rows.shape)


def _rigid(column: NDArray[np.int64], coordinate: Array, coincident: float) -> Array:
    """Rigid-body motions at displacements of nodes, about their middle, shape (columns, 6)."""
    node, axis = np.divmod(column, DIRECTIONS)
    arm = coordinate[node] - coordinate[node].mean(axis=0)
    # nodes on one spot but for rounding do not part in rotations
    size = abs(arm).max()
    arm = arm / size if size > coincident else np.zeros_like(arm)
    rigid = np.zeros((len(column), 2 * DIRECTIONS))
    rigid[np.arange(len(column)), axis] = 1.0
    for about in range(DIRECTIONS):
        i, j = (about + 1) % DIRECTIONS, (about + 2) % DIRECTIONS
        rigid[:, DIRECTIONS + about] = (axis == j) * arm[:, i] - (axis == i) * arm[:, j]
    return rigid
