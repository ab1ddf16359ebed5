"""Fit of a few elements to the many of a region."""

from typing import Any

from boltjoint.config.entries import Entry
from boltjoint.config.types import Count, Distinct, Fraction
from boltjoint.names import JointName


class Fitting(Entry):
    """Fit of joints ``.../elements=M``: M elements replace those of a region, as in the source."""

    initial_guesses: Count = 16
    """Initial guesses of the search; the best fit of all is kept."""
    load_fractions: Distinct[tuple[Fraction, Fraction, Fraction]] = (0.3, 0.6, 0.9)
    """Loops are fitted at the three displacement amplitudes at which a region carries these
    fractions of its slip force."""

    def fit(self, joint: str) -> dict[str, Any]:
        """The options of ``joint.reduced.fit_reduced_joint`` for a joint of this name."""
        parsed = JointName(joint)
        if parsed.reduction == "harmonic":
            return {"count": parsed.elements, "method": "describing-function"}
        options = {"starts": self.initial_guesses, "load_fractions": self.load_fractions}
        return {"count": parsed.elements, "method": "loops", **options}
