"""What a deck tells before anything is computed: sizes, bolts, supports, and what it lacks."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from boltjoint.config.deck import BoltsOfDeck, Summary
from boltjoint.config.described import MeshSize
from boltjoint.names import Preload
from boltjoint.structure.makers.deck.content import Boundary, Deck, Material, Reference
from boltjoint.structure.makers.deck.interfaces import faces_of_contact, tied_pairs
from boltjoint.structure.makers.deck.lines import Place
from boltjoint.structure.makers.deck.mesh import Mesh, mesh_of
from boltjoint.structure.makers.deck.pretension import bolts_of, loads_of, with_planes
from boltjoint.structure.makers.deck.reader import read_deck

if TYPE_CHECKING:
    from boltjoint.config.deck import Deck as Description
    from boltjoint.config.deck import DeckMaterial


def summary_of(description: "Description", folder: Path) -> Summary:
    """Sizes, bolts and supports of a deck.

    Raises
    ------
    ValueError
        If the deck cannot be read, or lacks what the description names.
    """
    mesh = described_mesh(description, folder)
    deck = mesh.deck
    mesh.blocks(1.0, 1.0)
    mesh.refuse_inverted()
    tied_pairs(description.contact, deck)
    points = 0
    for interface in description.contact:
        first, _ = faces_of_contact(mesh, interface)
        points += len(first) if interface.points == "faces" else len(first.nodes)
    elements = sum(len(solid.place) for solid in mesh.solids)
    held = any(len(deck.nodes_of(boundary.nodes)) for boundary in supports_of(description, deck))
    bolts = _bolts(description, deck)
    return Summary(MeshSize(len(mesh.nodes), elements, points), bolts, held)


def bolts_in(description: "Description", folder: Path) -> BoltsOfDeck:
    """Names and loads of the bolts of a deck.

    Raises
    ------
    ValueError
        If the deck cannot be read, or lacks the bolts.
    """
    return _bolts(description, described_mesh(description, folder).deck)


def _bolts(description: "Description", deck: Deck) -> BoltsOfDeck:
    bolts = bolts_of(deck, description.wanted_bolts)
    names = tuple(bolt.name for bolt in bolts)
    loads = loads_of(deck, bolts)
    if loads is None:
        return BoltsOfDeck(names, None)
    largest = float(loads.max())
    newton = description.units.newton
    return BoltsOfDeck(names, Preload.of(newton * largest, (loads / largest).tolist()))


def described_mesh(description: "Description", folder: Path) -> Mesh:
    """The mesh of a deck with the materials of its description.

    Raises
    ------
    ValueError
        As for ``read_deck``, or if there is no material of a name.
    """
    deck = read_deck(folder, description.file, description.kinds)
    length, mass, _ = description.units.factors
    for material in description.materials:
        key = material.name.upper()
        if key not in deck.materials:
            if deck.sections or not _has_all(material):
                there = ", ".join(one.name for one in deck.materials.values()) or "none"
                raise ValueError(
                    f"{deck.file} has no *MATERIAL {material.name}; there are: {there}"
                )
            deck.materials[key] = Material(material.name, Place(deck.file, 1))
        of_deck = deck.materials[key]
        modulus = _in_unit(material.youngs_modulus_GPa, 1e9 / description.units.pascal)
        ratio, density = (
            material.poissons_ratio,
            _in_unit(material.density_kg_per_m3, length**3 / mass),
        )
        deck.materials[key] = replace(
            of_deck,
            youngs_modulus=of_deck.youngs_modulus if modulus is None else modulus,
            poissons_ratio=of_deck.poissons_ratio if ratio is None else ratio,
            density=of_deck.density if density is None else density,
        )
    return with_planes(mesh_of(deck, length), description.wanted_bolts or ())


def _has_all(material: "DeckMaterial") -> bool:
    values = (material.youngs_modulus_GPa, material.poissons_ratio, material.density_kg_per_m3)
    return all(value is not None for value in values)


def _in_unit(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def supports_of(description: "Description", deck: Deck) -> Sequence[Boundary]:
    """Supports of the deck before its first step, none, or sets of nodes."""
    wanted = description.supports
    if wanted == "none":
        return []
    if wanted == "from deck":
        return [boundary for boundary in deck.boundaries if boundary.step == 0]
    supports = []
    for name in wanted:
        reference = Reference(name, "", Place(deck.file, 0))
        if deck.node_sets.key("", name) is None and not name.isdigit():
            there = ", ".join(deck.node_sets.written.values()) or "none"
            raise ValueError(f"{deck.file} has no *NSET {name}; there are: {there}")
        if not np.size(deck.nodes_of(reference)):
            raise ValueError(f"{deck.file}: *NSET {name} has no nodes that could be held")
        supports.append(Boundary(reference, 1, 3, 0.0, 0))
    return supports
