"""A look at a deck before anything is solved: what it weighs, what holds it, what was left out."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from boltjoint.config.deck import Deck
from boltjoint.config.deck import Deck as Description
from boltjoint.structure.elements.suitability import element_warnings
from boltjoint.structure.makers.deck import beams_springs_masses, constraint_rows, interfaces
from boltjoint.structure.makers.deck.assembled import Assembled, constrain
from boltjoint.structure.makers.deck.interfaces import tied_pairs
from boltjoint.structure.makers.deck.labels import Indices
from boltjoint.structure.makers.deck.mesh import Mesh
from boltjoint.structure.makers.deck.pretension import (
    Cut,
    SectionBolt,
    bolts_of,
    lengths_given,
    loads_of,
)
from boltjoint.structure.makers.deck.summary import described_mesh, supports_of
from boltjoint.structure.model_facts import (
    MM,
    contact_in_words,
    direction_in_words,
    doubts_of_size,
)

Array = NDArray[np.float64]

_GPA = 1e-9
#: moduli [Pa], densities [kg/m3] and sizes [m] of assemblies
_MODULI, _DENSITIES, _SIZES = (5e8, 1e12), (200.0, 25e3), (1e-3, 50.0)
#: keywords and names of the deck that are told, at most
_MOST = 8


def check_of(description: Description, folder: str | Path) -> tuple[dict[str, str], list[str]]:
    """What a deck is, by words, and what to look at, in a line each.

    Parameters
    ----------
    description, folder
        As for ``structure_of_deck``.

    Raises
    ------
    ValueError
        As for ``structure_of_deck``, but for what solving finds.
    """
    as_read = described_mesh(description, Path(folder))
    as_read.refuse_inverted()
    boundaries = supports_of(description, as_read.deck)
    tolerance = description.ties.tolerance_mm
    assembled = constrain(
        as_read,
        boundaries=boundaries,
        tied_pairs=tied_pairs(description.contact, as_read.deck),
        tolerance=None if tolerance is None else tolerance / MM,
        adjust=description.ties.adjust,
    )
    facts = _of_bodies(description, as_read) | _of_constraints(assembled)
    facts |= _of_bolts(description, assembled) | _of_contact(description, assembled)
    deck = as_read.deck
    facts["sets of elements"] = _first(list(deck.element_sets.written.values()))
    facts["sets of nodes"] = _first(list(deck.node_sets.written.values()))
    facts["surfaces"] = _first([surface.name for surface in deck.surfaces.values()])
    facts["not used of the deck"] = _left_out(assembled)
    doubts = [*_doubts(description, as_read), *_of_ties(assembled)]
    if general := deck.unused.get("CONTACT"):
        doubts.append(
            f"{general[0]}: *CONTACT, of all surfaces, is not read: those under contact meet, and "
            "no others"
        )
    return facts, doubts


def _of_bodies(description: Description, mesh: Mesh) -> dict[str, str]:
    length, mass, _ = description.units.factors
    blocks = mesh.blocks(description.units.pascal, mass / length**3)
    weight = sum(
        float(volumes @ np.asarray(block.material.density, dtype=np.float64))
        for volumes, block in zip(mesh.volumes, blocks, strict=True)
    )
    weight += float(
        beams_springs_masses.point_masses(mesh, 3 * mesh.node_count, mass).diagonal()[::3].sum()
    )
    size = np.ptp(mesh.coordinate[mesh.nodes], axis=0)
    kinds = ", ".join(f"{len(solid.place)} {solid.kind.name}" for solid in mesh.solids)
    return {
        "nodes": str(len(mesh.nodes)),
        "elements": kinds,
        "volume (cm³)": f"{1e6 * mesh.volume:.6g}",
        "mass (kg)": f"{weight:.6g}",
        "size (mm)": " x ".join(f"{MM * edge:.5g}" for edge in size),
        "bodies": str(int(constraint_rows.bodies(mesh).max()) + 1),
    }


def _of_constraints(assembled: Assembled) -> dict[str, str]:
    mesh, unknowns = assembled.mesh, assembled.unknowns
    motions = constraint_rows.motions_of_bodies(mesh, unknowns, constraint_rows.bodies(mesh))
    free = constraint_rows.allowed(motions, assembled.rows, assembled.held).shape[1]
    ties = [
        f"{tie.name}: {len(tie.node)} nodes, up to {round(MM * tie.distance, 9):.3g} mm"
        for tie in assembled.ties
    ]
    return {
        "degrees of freedom": str(assembled.elimination.free.size),
        "rigid-body motions without contact": str(free),
        "held displacements": str(int(np.count_nonzero(assembled.held))),
        "ties": "; ".join(ties) or "none",
        "constraints that others imply": str(assembled.elimination.repeated),
    }


def _of_bolts(description: Description, assembled: Assembled) -> dict[str, str]:
    mesh = assembled.mesh
    bolts = bolts_of(mesh.deck, description.wanted_bolts)
    loads = loads_of(mesh.deck, bolts)
    lengths = lengths_given(mesh.deck, bolts)
    told, body, of_beams = (
        [],
        constraint_rows.bodies(mesh),
        beams_springs_masses.bolt_beams(mesh.deck),
    )
    for number, bolt in enumerate(bolts):
        words = [bolt.name]
        if isinstance(bolt, SectionBolt):
            section = mesh.deck.pretension[bolt.section]
            cut = next((other for other in assembled.cuts if other.section is section), None)
            if cut is not None:
                words.append(f"section of {len(cut.node)} nodes, {1e6 * cut.area:.4g} mm²")
                words += _axis(cut.normal, _length(mesh, body, cut))
            beam = next((other for other in of_beams if other.section is section), None)
            if beam is not None:
                along = np.subtract(*mesh.coordinate[beam.nodes[::-1]])
                length = float(np.linalg.norm(along))
                words.append(f"beam of {1e6 * beam.sizes[0] * mesh.metre**2:.4g} mm²")
                words += _axis(along / length, length)
        else:
            words.append(f"between two couplings, along {direction_in_words(bolt.direction)}")
            apart = np.subtract(*mesh.coordinate[bolt.node]) @ bolt.direction
            words.append(f"{MM * abs(apart):.5g} mm apart")
        if loads is not None:
            words.append(f"{description.units.newton * loads[number]:.6g} N in the deck")
        if bolt.name in lengths:
            words.append("given a length in the deck")
        told.append(", ".join(words))
    return {"bolts": "; ".join(told)}


def _axis(direction: Array, length: float) -> tuple[str, str]:
    return f"axis {direction_in_words(direction)}", f"{MM * length:.5g} mm long"


def _length(mesh: Mesh, body: Indices, cut: Cut) -> float:
    """Length along its axis of the body that a section cuts in two [m]."""
    both = np.isin(body, body[[cut.node[0], cut.copy[0]]])
    return float(np.ptp(mesh.coordinate[both] @ cut.normal))


def _of_contact(description: Description, assembled: Assembled) -> dict[str, str]:
    mesh, told, alone = assembled.mesh, [], []
    for interface in description.contact:
        one, other = interfaces.faces_of_contact(mesh, interface)
        points = interfaces.weighted(mesh, interface)
        areas = [
            np.linalg.norm(faces.area_vectors(mesh.coordinate), axis=1).sum()
            for faces in (one, other)
        ]
        told.append(contact_in_words(interface.name, points.area, points.gap))
        shares = ", ".join(
            f"{name} {points.area.sum() / area:.0%}"
            for name, area in zip(interface.surfaces, areas, strict=True)
        )
        alone.append(f"{interface.name}: {shares}")
    return {"contact": "; ".join(told), "share of the surfaces that meets": "; ".join(alone)}


def _first(names: list[str]) -> str:
    """Names of which there may be many."""
    more = f" and {len(names) - _MOST} more" if len(names) > _MOST else ""
    return ", ".join(names[:_MOST]) + more or "none"


def _left_out(assembled: Assembled) -> str:
    deck = assembled.mesh.deck
    told = [
        f"*{keyword} ({count}, first at {place})"
        for keyword, (place, count) in list(deck.unused.items())[:_MOST]
    ]
    if more := len(deck.unused) - len(told):
        told.append(f"{more} more keyword{'' if more == 1 else 's'}")
    of_steps = dict.fromkeys(
        boundary.nodes.text for boundary in deck.boundaries if boundary.step > 0
    )
    if of_steps:
        told.append(f"*BOUNDARY in steps ({_first(list(of_steps))})")
    if deck.steps:
        told.append(f"{deck.steps} step{'' if deck.steps == 1 else 's'}")
    return ", ".join(told) or "nothing"


def _doubts(description: Description, mesh: Mesh) -> list[str]:
    """Numbers that no joint has, as they may be in other units."""
    told = []
    materials, _ = mesh.materials
    length, mass, _ = description.units.factors
    for material in materials:
        modulus = description.units.pascal * (material.youngs_modulus or 0.0)
        density = mass / length**3 * (material.density or 0.0)
        if not _MODULI[0] <= modulus <= _MODULI[1]:
            guess = ": is it in MPa?" if _MODULI[0] <= 1e6 * modulus <= _MODULI[1] else ""
            told.append(
                f"material {material.name}: Young's modulus {_GPA * modulus:.4g} GPa is unusual"
                f"{guess}"
            )
        if not _DENSITIES[0] <= density <= _DENSITIES[1]:
            told.append(f"material {material.name}: density {density:.4g} kg/m³ is unusual")
    told += doubts_of_size("size", mesh.coordinate[mesh.nodes], _SIZES, "units.length")
    blocks = mesh.blocks(description.units.pascal, mass / length**3)
    return told + element_warnings(blocks)


def _of_ties(assembled: Assembled) -> list[str]:
    return [
        f"tie {tie.name}: {tie.apart} nodes are farther than {MM * tie.tolerance:.3g} mm from "
        "the master and stay free"
        for tie in assembled.ties
        if tie.apart
    ]


MEANING = "Solid bodies from a deck of Abaqus or CalculiX, with the constraints and bolts it has."


def facts_of(described: Deck) -> dict[str, float | str | tuple[float, ...]]:
    """Files, units and the check of the model, by what they are called."""
    facts, doubts = check_of(described, described.folder)
    pairs = (
        f"{interface.name}: {' on '.join(interface.surfaces)}" for interface in described.contact
    )
    modes = {
        "open": "without contact",
        "closed": "with normal springs of the points that are closed under preload",
    }
    return {
        "deck": ", ".join(described.named_files),
        "units of the deck": ", ".join(described.units.model_dump().values()),
        "surfaces in contact": "; ".join(pairs),
        "modes and bases": modes[described.base],
        "points": ", ".join(described.input_names) or "none",
        **facts,
        "to look at": "; ".join(doubts) or "nothing",
    }
