"""Bolts of a deck: sections through shanks or beams, or forces between two reference nodes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.deck.content import Deck, Load
from boltjoint.structure.makers.deck.labels import Indices

if TYPE_CHECKING:
    from boltjoint.config.deck import DeckBolt

Array = NDArray[np.float64]

#: forces of a bolt that differ by more do not balance
_APART = 1e-6


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
    known: DeckBolts = [
        SectionBolt((section.surface or section.element).text, number)
        for number, section in enumerate(deck.pretension)
    ]
    if wanted is None:
        known += _loaded_pairs(deck)
        if not known:
            raise ValueError(
                f"{deck.file} has no bolts: no *PRE-TENSION SECTION, and no opposite forces on "
                "two reference nodes that *EQUATION joins"
            )
        return known
    found: DeckBolts = []
    for each in wanted:
        if each.section is not None:
            names = {bolt.name.upper(): bolt for bolt in known}
            if each.section.upper() not in names:
                there = ", ".join(bolt.name for bolt in known) or "none"
                raise ValueError(
                    f"{deck.file} has no *PRE-TENSION SECTION of {each.section}; there are: {there}"
                )
            found.append(names[each.section.upper()]._replace(name=each.name))
        else:
            nodes = np.array([_reference_node(deck, name) for name in each.couplings])
            pair = next((one for one in _loaded_pairs(deck) if set(one.node) == set(nodes)), None)
            if pair is None:
                raise ValueError(
                    f"{deck.file}: couplings {', '.join(each.couplings)} of bolt {each.name} have "
                    "no opposite forces by *CLOAD, which tell its direction"
                )
            found.append(pair._replace(name=each.name))
    return found


def loads_of(deck: Deck, bolts: DeckBolts) -> Array | None:
    """Tensions that the deck gives its bolts, in its units; None where it gives not all."""
    tensions = []
    for bolt in bolts:
        if isinstance(bolt, SectionBolt):
            node = deck.node_of(deck.pretension[bolt.section].node)
            forces = [each.force for each in deck.loads if node in deck.nodes_of(each.nodes)]
            tensions.append(next((abs(force) for force in forces if force), 0.0))
        else:
            force = _force_on(deck, int(bolt.node[0]))
            tensions.append(float(np.linalg.norm(force)))
    return np.array(tensions) if all(tensions) else None


def lengths_given(deck: Deck, bolts: DeckBolts) -> list[str]:
    """Names of bolts that the deck shortens by a length instead of a force."""
    found = []
    for bolt in bolts:
        if isinstance(bolt, SectionBolt):
            node = deck.node_of(deck.pretension[bolt.section].node)
            if any(each.value and node in deck.nodes_of(each.nodes) for each in deck.boundaries):
                found.append(bolt.name)
    return found


def _reference_node(deck: Deck, name: str) -> int:
    """The reference node of a coupling of this name, or the node itself, or that of a set."""
    for each in deck.couplings:
        if each.of_surface and name.upper() in (each.name.upper(), each.reference.text.upper()):
            return deck.node_of(each.reference)
    there = ", ".join(each.name or each.reference.text for each in deck.couplings) or "none"
    raise ValueError(f"{deck.file} has no *COUPLING {name}; there are: {there}")


def _loaded_pairs(deck: Deck) -> list[CouplingBolt]:
    """Pairs of reference nodes that equations join and opposite forces load."""
    reference = {
        deck.node_of(each.reference): each.name or each.reference.text
        for each in deck.couplings
        if each.of_surface
    }
    joined: dict[int, set[int]] = {}
    for equation in deck.equations:
        nodes = {int(node) for term in equation.terms for node in deck.nodes_of(term.node)}
        own = nodes & reference.keys()
        for node in own:
            joined.setdefault(node, set()).update(own)
    pairs = []
    for first in reference:
        others = joined.get(first, set()) - {first}
        if len(others) != 1 or (second := next(iter(others))) in [p.node[0] for p in pairs]:
            continue
        force, opposite = _force_on(deck, first), _force_on(deck, second)
        size = float(np.linalg.norm(force))
        if size and np.linalg.norm(force + opposite) <= _APART * size:
            nodes = np.array([first, second])
            pairs.append(CouplingBolt(reference[first], nodes, force / size))
    return pairs


def _force_on(deck: Deck, node: int) -> Array:
    """Force on a node in the first step that has one, along x, y, z."""
    own: list[Load] = [each for each in deck.loads if node in deck.nodes_of(each.nodes)]
    force = np.zeros(3)
    for each in own:
        if each.step == own[0].step and each.dof <= 3:
            force[each.dof - 1] += each.force
    return force
