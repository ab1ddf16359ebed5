"""What pages state of a structure from a deck."""

from boltjoint.config.deck import Deck
from boltjoint.structure.makers.deck.model_check import check_of

MEANING = "Solid bodies from a deck of Abaqus or CalculiX, with the constraints and bolts it has."


def facts_of(described: Deck) -> dict[str, float | str | tuple[float, ...]]:
    """Files, units and the check of the model, by what they are called."""
    facts, doubts = check_of(described, described.folder)
    pairs = (f"{each.name}: {' on '.join(each.surfaces)}" for each in described.contact)
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
