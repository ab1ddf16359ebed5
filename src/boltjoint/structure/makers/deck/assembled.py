"""Bodies of a deck with their constraints: from all displacements to those that are free."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.structure.elements.assembly import assemble
from boltjoint.structure.elements.matrices import ElementOptions
from boltjoint.structure.makers.deck import beams_springs_masses, constraint_rows
from boltjoint.structure.makers.deck.content import Boundary, ContactPair, Deck, Tie
from boltjoint.structure.makers.deck.distributing import (
    DistributingCoupling,
    coupled_nodes,
    distributing_couplings,
)
from boltjoint.structure.makers.deck.labels import Indices
from boltjoint.structure.makers.deck.mesh import Mesh
from boltjoint.structure.makers.deck.pretension import Cut, cut
from boltjoint.structure.makers.deck.unknowns import AXES, Elimination, Rows, Unknowns, eliminate

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Assembled:
    """Bodies of a deck with their constraints.

    Attributes
    ----------
    mesh
        Bodies, whose sections are cut and tied nodes moved.
    unknowns
        All of them.
    cuts
        Sections of bolts through elements, first of the sections of ``unknowns``.
    beams
        Beams of bolts, whose sections are the others.
    rows
        Constraints.
    held
        Unknowns that are zero.
    elimination
        What the constraints leave.
    ties
        What is tied.
    """

    mesh: Mesh
    unknowns: Unknowns
    cuts: tuple[Cut, ...]
    beams: tuple[beams_springs_masses.BoltBeam, ...]
    rows: list[Rows]
    held: NDArray[np.bool_]
    elimination: Elimination
    ties: tuple[constraint_rows.TiedNodes, ...]


def constrain(
    mesh: Mesh,
    *,
    boundaries: Sequence[Boundary],
    tied_pairs: Sequence[ContactPair] = (),
    tolerance: float | None = None,
    adjust: str = "near",
) -> Assembled:
    """The constraints of a deck.

    Parameters
    ----------
    mesh
        Its bodies.
    boundaries
        Supports.
    tied_pairs
        Contact pairs that are tied.
    tolerance
        Of all ties [m]; by default that of each.
    adjust
        Which tied nodes are moved onto the faces, as for ``constraint_rows.tie``.

    Raises
    ------
    ValueError
        If a constraint makes no sense: file, line and name.
    """
    deck = mesh.deck
    cuts = []
    for section in deck.pretension:
        if section.surface is not None:
            mesh, section_cut = cut(mesh, section)
            cuts.append(section_cut)
    bolt_beams = beams_springs_masses.bolt_beams(deck)
    for bolt in bolt_beams:
        # refused before anything is solved
        bolt.axes(mesh.coordinate)
    taken: dict[int, str] = {}
    of_ties, ties = [], []
    for tie, is_strict in [
        *((tie, True) for tie in deck.ties),
        *((_tie_of(pair), False) for pair in tied_pairs),
    ]:
        mesh, of_tie, tied = constraint_rows.tie(
            mesh, tie, tolerance, taken, is_strict=is_strict, adjust=adjust
        )
        of_ties.append(of_tie)
        ties.append(tied)
    turning = _turning(deck)
    couplings = distributing_couplings(deck, mesh, turning)
    sections = [*(bolt.section for bolt in cuts), *(bolt.section for bolt in bolt_beams)]
    displacements = AXES * mesh.node_count
    sums = [coupling.sums(displacements) for coupling in couplings.values()]
    sums = sparse.vstack([sparse.csr_array((0, displacements)), *sums], format="csr")
    unknowns = Unknowns(
        deck, mesh.node_count, turning, [deck.node_of(section.node) for section in sections], sums
    )
    rows = [_wide(of_tie, unknowns.size) for of_tie in of_ties]
    rows += constraint_rows.section_rows(cuts, unknowns)
    rows += _couplings(deck, unknowns, mesh, couplings)
    rows.append(constraint_rows.equation_rows(deck.equations, unknowns, mesh))
    held, supports = constraint_rows.support_rows(boundaries, unknowns, mesh)
    rows.append(supports)
    rows = [constraint for constraint in rows if constraint.matrix.shape[0]]
    kept = np.zeros(unknowns.size, bool)
    kept[unknowns.size - len(unknowns.sections) :] = True
    return Assembled(
        mesh,
        unknowns,
        tuple(cuts),
        tuple(bolt_beams),
        rows,
        held,
        eliminate(rows, held, kept),
        tuple(ties),
    )


def _tie_of(pair: ContactPair) -> Tie:
    name = f"{pair.slave.text}, {pair.master.text}"
    return Tie(name, pair.slave, pair.master, None, pair.place)


def _wide(rows: Rows, size: int) -> Rows:
    matrix = rows.matrix.tocsr()
    matrix.resize((matrix.shape[0], size))
    return rows._replace(matrix=matrix)


def _turning(deck: Deck) -> Indices:
    """Nodes that have a rotation."""
    turning: list[int] = []
    for coupling in deck.couplings:
        if coupling.of_surface:
            turning.append(deck.node_of(coupling.reference))
    turning += [deck.node_of(body.reference) for body in deck.rigid_bodies]
    turning += [int(node) for ends in beams_springs_masses.turning_beams(deck) for node in ends]
    return np.unique(np.array(turning, np.int64))


def _couplings(
    deck: Deck, unknowns: Unknowns, mesh: Mesh, distributing: dict[int, DistributingCoupling]
) -> list[Rows]:
    rows, first = [], unknowns.first_sum
    for number, coupling in enumerate(deck.couplings):
        if coupling.kind == "kinematic":
            name = f"{coupling.place}: *COUPLING {coupling.name or number + 1}"
            reference = deck.node_of(coupling.reference)
            node, _ = coupled_nodes(mesh, coupling)
            node = mesh.with_copies(mesh.origin[node])
            rows.append(
                constraint_rows.kinematic_rows(name, reference, node, coupling.dofs, unknowns, mesh)
            )
        elif number in distributing:
            rows.append(distributing[number].rows(unknowns, first))
            first += sum(len(factors) for _, factors in distributing[number].groups)
    for body in deck.rigid_bodies:
        name = f"{body.place}: *RIGID BODY"
        if body.kind == "elements":
            place = deck.elements_of(body.nodes)
            node = np.unique(
                np.concatenate(
                    [solid.node[np.isin(solid.place, place)].ravel() for solid in mesh.solids]
                )
            )
        else:
            node = mesh.with_copies(deck.nodes_of(body.nodes))
        reference = deck.node_of(body.reference)
        rows.append(
            constraint_rows.kinematic_rows(name, reference, node, body.dofs, unknowns, mesh)
        )
    return rows


def matrices(
    assembled: Assembled,
    options: ElementOptions,
    pascal: float = 1.0,
    kilogram_per_m3: float = 1.0,
    newton: float = 1.0,
    kilogram: float = 1.0,
) -> tuple[sparse.csc_array, sparse.csc_array]:
    """Stiffness and mass of all unknowns, nothing constrained.

    Parameters
    ----------
    assembled
        Bodies.
    options
        Integration of the elements.
    pascal, kilogram_per_m3, newton, kilogram
        Units of the deck.
    """
    mesh, unknowns = assembled.mesh, assembled.unknowns
    K, M = assemble(mesh.coordinate, mesh.blocks(pascal, kilogram_per_m3), options)
    size = unknowns.size
    K, M = sparse.csc_array(K), sparse.csc_array(M)
    K.resize((size, size))
    M.resize((size, size))
    K = K + beams_springs_masses.stiffness(assembled.beams, unknowns, mesh, pascal)
    K = K + beams_springs_masses.spring_stiffness(mesh, size, newton)
    return K.tocsc(), (M + beams_springs_masses.point_masses(mesh, size, kilogram)).tocsc()
