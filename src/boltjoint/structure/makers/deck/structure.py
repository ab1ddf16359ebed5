"""The structure of a deck: bodies, constraints, contact, bolts, supports and points."""

import logging
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.config.bolts import CLASS_8_8, S355, yield_strength
from boltjoint.config.deck import Deck as Description
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.elements.matrices import ElementOptions
from boltjoint.structure.geometry import CellMaterial, Geometry
from boltjoint.structure.makers.deck import beams_springs_masses, constraint_rows
from boltjoint.structure.makers.deck.assembled import Assembled, constrain, matrices
from boltjoint.structure.makers.deck.interfaces import points_of_contact, tied_pairs
from boltjoint.structure.makers.deck.mesh import Mesh
from boltjoint.structure.makers.deck.pretension import (
    DeckBolts,
    SectionBolt,
    bolts_of,
    lengths_given,
    loads_of,
)
from boltjoint.structure.makers.deck.summary import described_mesh, supports_of
from boltjoint.structure.model import Bolt, Row, Structure, unit_row
from boltjoint.structure.nonmatching_faces.weighted_points import WeightedPoints
from boltjoint.structure.preload import apply_preload

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: of the maker
NAME = "deck"
_MM = 1e-3
#: slip of contact points in a motion of bodies, below which it is one of the whole
_WHOLE = 1e-7


@dataclass(frozen=True, eq=False)
class DeckModel:
    """A deck on its way to a structure, for what is told of it.

    Attributes
    ----------
    as_read
        The mesh before nodes were moved and doubled.
    assembled
        Bodies and constraints.
    bolts
        Of the deck, in the order of their preloads.
    loads
        Tensions that the deck gives them [N], None where not.
    contact
        All contact points.
    by_pair
        Those of each pair of surfaces, with signed gaps.
    structure
        Without contact, or with normal springs of the base.
    mechanisms
        Motions of bodies that contact alone restrains.
    """

    as_read: Mesh
    assembled: Assembled
    bolts: DeckBolts
    loads: Array | None
    contact: ContactPoints
    by_pair: dict[str, WeightedPoints]
    structure: Structure
    mechanisms: int


def structure_of_deck(description: Description, folder: str | Path) -> Structure:
    """The structure that a deck describes.

    Parameters
    ----------
    description
        Deck, units, contact and points.
    folder
        Of the study, in which all files lie.

    Raises
    ------
    ValueError
        If the deck cannot be read, or is no structure: file, line and problem in one line.
    """
    return model_of_deck(description, folder).structure


def model_of_deck(description: Description, folder: str | Path) -> DeckModel:
    """The structure of a deck, and what it came from, as ``structure_of_deck``."""
    try:
        return _model(description, folder)
    except (ValueError, RuntimeError) as error:
        text = " ".join(str(error).split())
        if text.startswith(description.file):
            raise
        raise ValueError(f"{description.file}: {text}") from error


def _model(description: Description, folder: str | Path) -> DeckModel:
    as_read = described_mesh(description, Path(folder))
    deck = as_read.deck
    bolts = bolts_of(deck, description.wanted_bolts)
    boundaries = supports_of(description, deck)
    tolerance = description.ties.tolerance_mm
    assembled = constrain(
        as_read,
        boundaries=boundaries,
        tied_pairs=tied_pairs(description.contact, deck),
        tolerance=None if tolerance is None else _MM * tolerance,
        adjust=description.ties.adjust,
    )
    length, mass, _ = description.units.factors
    K, M = matrices(
        assembled,
        ElementOptions(description.mass, description.hourglass_factor),
        description.units.pascal,
        mass / length**3,
        description.units.newton,
        mass,
    )
    T, unknowns = assembled.elimination.transformation, assembled.unknowns
    stiffness, inertia = ((T.T @ matrix @ T).tocsc() for matrix in (K, M))
    acting = np.flatnonzero((stiffness.diagonal() != 0) | (inertia.diagonal() != 0))
    T = sparse.csc_array(T[:, acting])
    stiffness, inertia = (
        sparse.csc_array(matrix[acting][:, acting]) for matrix in (stiffness, inertia)
    )
    mesh = assembled.mesh
    displacement = sparse.csc_array(T[: 3 * mesh.node_count])
    contact, by_pair = points_of_contact(mesh, displacement, description.contact)
    if not description.has_initial_gap:
        contact = replace(contact, gap=np.zeros(len(contact)))
    whole, mechanisms = _motions(assembled, T, contact)
    support = None
    if boundaries:
        unit = np.zeros((unknowns.size, 3))
        unit[: 3 * mesh.node_count] = np.tile(np.eye(3), (mesh.node_count, 1))
        support = -(T.T @ (M @ unit)).T
    loads = loads_of(deck, bolts)
    rows = _rows(description, mesh, displacement)
    structure = Structure(
        stiffness=(stiffness + stiffness.T) / 2,
        mass=(inertia + inertia.T) / 2,
        contact=contact,
        bolts=_bolts(description, assembled, bolts, T),
        inputs=rows,
        outputs=rows,
        support=support,
        rigid=whole,
        geometry=_geometry(description, mesh, displacement),
        maker=NAME,
        factorisation=description.factorisation,
    )
    if description.base == "closed":
        structure = _closed(structure, assembled, T, loads)
    elif mechanisms:
        raise ValueError(
            f"{deck.file}: without contact {mechanisms} motions of bodies are free: tie what holds "
            "them together, or give base: closed"
        )
    model = DeckModel(
        as_read,
        assembled,
        bolts,
        None if loads is None else description.units.newton * loads,
        contact,
        by_pair,
        structure,
        mechanisms,
    )
    _log(model, lengths_given(deck, bolts))
    return model


def _motions(
    assembled: Assembled, T: sparse.csc_array, contact: ContactPoints
) -> tuple[Array, int]:
    """Rigid-body motions of the whole, shape (dofs, motions), and how many of bodies more."""
    mesh, unknowns = assembled.mesh, assembled.unknowns
    motions = constraint_rows.motions_of_bodies(mesh, unknowns, constraint_rows.bodies(mesh))
    factors = constraint_rows.allowed(motions, assembled.rows, assembled.held)
    # each unknown that is left is one of all, with the factor 1
    free = assembled.elimination.free
    column = T.shape[1]
    own = _own_unknowns(T, free)
    q = (motions @ factors)[own].reshape(column, -1)
    if not q.size:
        return np.zeros((column, 0)), 0
    slip = contact.relative @ q
    _, size, turn = np.linalg.svd(slip, full_matrices=True)
    size = np.concatenate([size, np.zeros(len(turn) - len(size))])
    largest = abs(q[own < 3 * mesh.node_count]).max()
    is_whole = size <= _WHOLE * np.sqrt(len(slip)) * largest
    return q @ turn[is_whole].T, int(np.count_nonzero(~is_whole))


def _own_unknowns(T: sparse.csc_array, free: NDArray[np.int64]) -> NDArray[np.int64]:
    """The unknown that each column of T is: the free one in which it has the factor 1."""
    is_free = np.zeros(T.shape[0], bool)
    is_free[free] = True
    coordinates = T.tocoo()
    own = is_free[coordinates.coords[0]] & (coordinates.data == 1.0)
    unknown = np.full(T.shape[1], -1)
    unknown[coordinates.coords[1][own]] = coordinates.coords[0][own]
    return unknown


def _closed(
    structure: Structure, assembled: Assembled, T: sparse.csc_array, loads: Array | None
) -> Structure:
    """The structure with normal springs of the points that are closed under preload."""
    contact, every = structure.contact, np.arange(len(structure.contact))
    _check_sliding(structure, assembled, T, every)
    tension = np.ones(len(structure.bolts)) if loads is None else loads / loads.max()
    preload = apply_preload(structure, tension.tolist())
    springs = np.where(preload["normal_load"] > 0, contact.penalty * contact.area, 0.0)
    _check_sliding(structure, assembled, T, np.flatnonzero(springs))
    return replace(structure, base_springs=springs)


def _check_sliding(
    structure: Structure,
    assembled: Assembled,
    T: sparse.csc_array,
    closed: NDArray[np.int64],
) -> None:
    """Refuse bodies that slide where the normal displacement of closed points is zero."""
    mesh, unknowns = assembled.mesh, assembled.unknowns
    motions = constraint_rows.motions_of_bodies(mesh, unknowns, constraint_rows.bodies(mesh))
    own = _own_unknowns(T, assembled.elimination.free)
    wide = sparse.coo_array(structure.contact.relative[3 * closed + 2])
    places = wide.coords[0], own[wide.coords[1]]
    rows = sparse.coo_array((wide.data, places), shape=(len(closed), unknowns.size)).tocsr()
    left = constraint_rows.allowed(motions, assembled.rows, assembled.held, rows).shape[1]
    sliding = left - structure.rigid_body_motions.shape[1]
    if sliding > 0:
        raise ValueError(
            f"{mesh.deck.file}: with contact closed {sliding} motions of bodies along the surfaces "
            "are free, which friction alone holds: leave pairs out of contact, and they are tied"
        )


def _bolts(
    description: Description, assembled: Assembled, bolts: DeckBolts, T: sparse.csc_array
) -> tuple[Bolt, ...]:
    mesh, unknowns = assembled.mesh, assembled.unknowns
    deck, dofs = mesh.deck, T.shape[1]
    own = _own_unknowns(T, assembled.elimination.free)
    of_structure = []
    for bolt in bolts:
        if not isinstance(bolt, SectionBolt):
            force = np.zeros(unknowns.size)
            for node, sign in zip(bolt.node, (1.0, -1.0), strict=True):
                force[unknowns.translations(np.array(node))] += sign * bolt.direction
            place = mesh.coordinate[bolt.node].mean(axis=0)
            of_structure.append(Bolt(bolt.name, T.T @ force, None, bolt.direction, place))
            continue
        section = deck.pretension[bolt.section]
        node = deck.node_of(section.node)
        locked = int(np.flatnonzero(own == unknowns.shortening(unknowns.sections.index(node)))[0])
        load = unit_row(locked, dofs)
        if section.surface is not None:
            cut = next(one for one in assembled.cuts if one.section is section)
            materials, number = mesh.materials
            material = materials[number[cut.element]]
            modulus = material.youngs_modulus * description.units.pascal
            strength = _strength(description, material.name, modulus, CLASS_8_8)
            values = cut.normal, cut.centre, cut.area, modulus, strength
        else:
            beam = next(one for one in assembled.beams if one.section is section)
            values = _of_beam(description, mesh, beam)
        of_structure.append(Bolt(bolt.name, load, locked, *values))
    return tuple(of_structure)


def _of_beam(
    description: Description, mesh: Mesh, beam: beams_springs_masses.BoltBeam
) -> tuple[Array, Array, float, float, float]:
    """Axis, position, section, modulus and yield strength of a bolt that is a beam."""
    along = np.subtract(*mesh.coordinate[beam.nodes[::-1]])
    material = mesh.deck.materials[beam.beam.material.upper()]
    modulus = material.elasticity[0] * description.units.pascal
    return (
        along / np.linalg.norm(along),
        mesh.coordinate[beam.nodes].mean(axis=0),
        mesh.metre**2 * beam.sizes[0],
        modulus,
        _strength(description, material.name, modulus, CLASS_8_8),
    )


def _strength(
    description: Description, material: str, modulus: float, of_steel: float = S355
) -> float:
    """Yield strength of a material of the deck [Pa], as of ``yield_strength``."""
    given = {own.name.upper(): own.yield_strength_MPa for own in description.materials}
    return yield_strength(given.get(material.upper()), 1e-9 * modulus, of_steel)


def _rows(description: Description, mesh: Mesh, displacement: sparse.csc_array) -> dict[str, Row]:
    """Rows of the nodes that are nearest to the points."""
    rows, by_row = {}, displacement.tocsr()
    for point in description.points:
        apart = mesh.coordinate[mesh.nodes] - _MM * np.array(point.near_mm)
        node = int(mesh.nodes[np.argmin(np.linalg.norm(apart, axis=1))])
        row = by_row[[3 * node + "xyz".index(point.direction)]].toarray()[0]
        if not row.any():
            raise ValueError(
                f"point {point.name}: {mesh.deck.nodes.name(int(mesh.origin[node]))}, the nearest, "
                f"is held along {point.direction}"
            )
        rows[point.name] = Row(row, point.direction)
    return rows


def _geometry(description: Description, mesh: Mesh, displacement: sparse.csc_array) -> Geometry:
    """Nodes of the elements, their motion, and cells in the order of VTK, by bodies."""
    number = np.full(mesh.node_count, -1)
    number[mesh.nodes] = np.arange(len(mesh.nodes))
    most = max(solid.kind.nodes for solid in mesh.solids)
    body, cells, parts = constraint_rows.bodies(mesh), [], []
    for solid in mesh.solids:
        cell = np.full((len(solid.place), most), -1)
        cell[:, : solid.kind.nodes] = number[solid.node[:, solid.kind.vtk_order]]
        cells.append(cell)
        parts.append(body[solid.node[:, 0]])
    rows = (3 * mesh.nodes[:, None] + np.arange(3)).ravel()
    moved = sparse.csc_array(displacement.tocsr()[rows])
    return Geometry(
        mesh.coordinate[mesh.nodes],
        moved,
        np.concatenate(cells),
        np.concatenate(parts),
        _cell_material(description, mesh),
    )


def _cell_material(description: Description, mesh: Mesh) -> CellMaterial:
    materials, number = mesh.materials
    of_solids = [block.material for block in mesh.blocks(description.units.pascal, 1.0)]
    modulus = np.concatenate([material.youngs_modulus for material in of_solids])
    of_cell = np.concatenate([number[solid.place] for solid in mesh.solids])
    strength = np.empty_like(modulus)
    for index in np.unique(of_cell):
        mine = of_cell == index
        strength[mine] = _strength(description, materials[index].name, modulus[mine][0])
    ratio = np.concatenate([material.poissons_ratio for material in of_solids])
    return CellMaterial(modulus, ratio, strength)


def _log(model: DeckModel, lengths: list[str]) -> None:
    deck = model.assembled.mesh.deck
    logger.info(
        "%s: %d nodes, %d degrees of freedom, %d contact points, %d rigid-body motions",
        deck.file,
        len(model.assembled.mesh.nodes),
        model.structure.dofs,
        len(model.contact),
        model.structure.rigid_body_motions.shape[1],
    )
    for tie in model.assembled.ties:
        if tie.apart:
            logger.info(
                "tie %s: %d slaves beyond %.3g mm", tie.name, tie.apart, 1e3 * tie.tolerance
            )
    for name in lengths:
        logger.warning("bolt %s: the deck gives a length; its preload is that of the case", name)
