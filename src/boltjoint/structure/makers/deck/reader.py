"""Decks of Abaqus and CalculiX: nodes, elements, sets, surfaces, constraints, bolts, contact.

What changes a structure in a way that is not modelled is refused by file and line; other keywords
are counted. Constraints count before the first step alone: those of steps hold what steps need.

References
----------
Abaqus 2023 Keywords Guide, Dassault Systemes Simulia.
G. Dhondt: CalculiX CrunchiX User's Manual, version 2.20.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.deck import lines, mesh_keywords, model_keywords
from boltjoint.structure.makers.deck.content import Deck, Elements, Reading
from boltjoint.structure.makers.deck.lines import Block, read_blocks

Array = NDArray[np.float64]

_HANDLERS = mesh_keywords.HANDLERS | model_keywords.HANDLERS
#: coordinate of a node, in units of the deck, that no body has
_FARTHEST = 1e12
#: keywords that say how an analysis runs or what it writes, not what the structure is
_SILENT = {"HEADING", "PREPRINT", "END STEP", "ASSEMBLY", "END ASSEMBLY", "END PART", "STEP"}
_SILENT |= {"END INSTANCE", "RESTART", "PARAMETER"}


def read_deck(folder: str | Path, file: str, kinds: Mapping[str, str] | None = None) -> Deck:
    """The content of a deck.

    Parameters
    ----------
    folder
        From which the file is seen, and within which it and what it includes lie.
    file
        The deck.
    kinds
        Kinds of elements that are read as others, as ``{"C3D8R": "C3D8I"}``.

    Raises
    ------
    ValueError
        If a line is none of a deck, or tells something that is not modelled: one line of text with
        file, line, keyword and what is wrong.
    """
    reading = Reading(Deck(file), dict(kinds or {}))
    _read(reading, read_blocks(Path(folder), file))
    _finish(reading)
    return reading.deck


def _read(reading: Reading, blocks: Iterable[Block]) -> None:
    parts: dict[str, list[Block]] = {}
    part: list[Block] | None = None
    for block in blocks:
        if block.keyword == "PART":
            part = parts.setdefault(block.option("NAME").upper(), [])
        elif block.keyword == "END PART":
            part = None
        elif part is not None:
            part.append(block)
        elif block.keyword == "INSTANCE":
            _begin_instance(reading, block, parts)
        elif block.keyword == "END INSTANCE":
            _end_instance(reading)
        else:
            _read_block(reading, block)


def _begin_instance(reading: Reading, block: Block, parts: Mapping[str, list[Block]]) -> None:
    name, part = block.option("NAME").upper(), block.option("PART").upper()
    if name in reading.instances:
        raise block.refused(f"there are two of the name {name}")
    if part not in parts:
        raise block.refused(f"there is no part {block.options['PART']}")
    reading.instances.add(name)
    reading.scope = name
    translation = np.array(lines.reals(block, 0, 3)) if block.rows else np.zeros(3)
    rotation = np.eye(3)
    if len(block.rows) > 1:
        a, b, angle = np.split(np.array(lines.reals(block, 1, 7)), [3, 6])
        if angle[0]:
            if not np.linalg.norm(b - a) > 0:
                raise block.refused("its axis of rotation is a point", 1)
            rotation = _rotation((b - a) / np.linalg.norm(b - a), np.deg2rad(angle[0]))
            # the part is moved first and then turned about the axis
            translation = rotation @ (translation - a) + a
    reading.motion = (rotation, translation)
    for of_part in parts[part]:
        _read_block(reading, of_part)
    reading.system = (np.eye(3), np.zeros(3))


def _end_instance(reading: Reading) -> None:
    reading.scope = ""
    reading.motion = reading.system = (np.eye(3), np.zeros(3))


def _rotation(axis: Array, angle: float) -> Array:
    """Rotation about an axis through the origin (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _read_block(reading: Reading, block: Block) -> None:
    keyword = block.keyword
    if keyword == "STEP":
        reading.step += 1
        reading.deck.steps = reading.step
    if reading.step:
        handler = model_keywords.IN_STEPS.get(keyword)
    elif keyword in model_keywords.REFUSED:
        raise block.refused(model_keywords.REFUSED[keyword])
    else:
        handler = _HANDLERS.get(keyword)
    if handler is not None:
        handler(reading, block)
    elif not reading.step and keyword not in _SILENT:
        place, count = reading.deck.unused.get(keyword, (block.place, 0))
        reading.deck.unused[keyword] = place, count + 1


def _finish(reading: Reading) -> None:
    """Find the nodes of the elements, which may have been told before them."""
    deck = reading.deck
    if not len(deck.nodes):
        raise ValueError(f"{deck.file} has no *NODE: it is no deck of a structure")
    deck.coordinate = np.concatenate(reading.coordinates)
    far = abs(deck.coordinate).max(axis=1) > _FARTHEST
    if far.any():
        node = int(np.argmax(far))
        place = reading.place_of_node(node)
        raise ValueError(f"{place}: {deck.nodes.name(node)} lies beyond {_FARTHEST:g}")
    for one, other in deck.nodes.twice():
        if not np.array_equal(deck.coordinate[one], deck.coordinate[other]):
            places = [str(reading.place_of_node(index)) for index in (one, other)]
            raise ValueError(
                f"{places[1]}: {deck.nodes.name(other)} stands elsewhere at {places[0]}: give "
                "each node one number, or each body an *INSTANCE"
            )
    for one, _ in deck.numbers.twice():
        at = next(
            block.place
            for _, _, place, _, block in reversed(reading.connectivity)
            if np.any(deck.numbers.label[place] == deck.numbers.label[one])
        )
        raise ValueError(f"{at}: {deck.numbers.name(one)} is there already")
    for scope, kind, number, label, block in reading.connectivity:
        nodes = deck.nodes.places(scope, label.ravel(), block.place).reshape(label.shape)
        deck.elements.append(Elements(kind, number, nodes, block.place))
