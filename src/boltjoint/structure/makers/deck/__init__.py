"""Structures from decks of Abaqus and CalculiX."""

from pathlib import Path
from typing import TYPE_CHECKING

from boltjoint.config.deck import BoltsOfDeck, Summary
from boltjoint.config.deck import Deck as Description

if TYPE_CHECKING:
    from boltjoint.config.described import MeshSize
    from boltjoint.structure.model import Structure

__all__ = [
    *("CALCULIX", "PAGE", "Description"),
    *("bolts_in", "check", "files_of", "make", "size_of", "summary_of"),
]


#: module that tells pages of them
PAGE = f"{__name__}.model_check"
#: module that writes decks for CalculiX and compares what it finds
CALCULIX = f"{__name__}.calculix"


def make(description: Description, folder: Path) -> "Structure":
    """The structure."""
    from boltjoint.structure.makers.deck.structure import structure_of_deck

    return structure_of_deck(description, folder)


def summary_of(description: Description, folder: Path) -> Summary:
    """Sizes, bolts and supports."""
    from boltjoint.structure.makers.deck import summary

    return summary.summary_of(description, folder)


def bolts_in(description: Description, folder: Path) -> BoltsOfDeck:
    """Names and loads of the bolts."""
    from boltjoint.structure.makers.deck import summary

    return summary.bolts_in(description, folder)


def size_of(description: Description, folder: Path) -> "MeshSize":
    """Nodes, elements and contact points."""
    return summary_of(description, folder).size


def files_of(description: Description, folder: Path) -> tuple[str, ...]:
    """The deck and all files that it includes."""
    from boltjoint.structure.makers.deck.lines import included_files

    return included_files(folder, description.file)


def check(description: Description, folder: Path) -> tuple[dict[str, str], list[str]]:
    """What a deck is, by words, and what to look at before anything is solved."""
    from boltjoint.structure.makers.deck.model_check import check_of

    return check_of(description, folder)
