"""Fit of a few elements to the many of a region."""

from typing import Any

from boltjoint.config.entries import Entry
from boltjoint.config.types import Count, Distinct, Fraction
from boltjoint.names import REDUCTIONS, JointName


class Fitting(Entry):
    """Fit of joints ``.../elements=M``: M elements replace those of a region, as in the source."""

    initial_guesses: Count = 16
    """Initial guesses of the search; the best fit of all is kept."""
    load_fractions: Distinct[tuple[Fraction, Fraction, Fraction]] = (0.3, 0.6, 0.9)
    """Loops are fitted at the three displacement amplitudes at which a region carries these
    fractions of its slip force."""

    def options(self, joint: str) -> dict[str, Any]:
        """The reduction of a joint of this name, and its options, as for ``reduce_joint``."""
        parsed = JointName(joint)
        reduction = REDUCTIONS[parsed.reduction]
        count = {"count": parsed.elements} if reduction.has_count else {}
        keys = {argument: getattr(self, key) for key, argument in reduction.options.items()}
        return {"reduction": reduction.name, **count, **keys}
