"""Accuracy of hyper-reduced joints."""

from typing import Any

from boltjoint.config.entries import Entry
from boltjoint.config.types import Fraction
from boltjoint.names import JointName


class HyperReduction(Entry):
    """Accuracy of the joints ``hyper=auto``, in which few weighted contact pairs stand for all.

    They have the fewest pairs with which no peak of the resonances that are solved is estimated to
    have a larger error, under any force between the smallest and the largest of the case.
    """

    frequency_tolerance: Fraction = 1e-3
    """Relative error of the frequency of a peak."""
    amplitude_tolerance: Fraction = 1e-2
    """The same of its amplitude."""

    def options(self, joint: str) -> dict[str, Any]:
        """The options of ``hyper_reduction.weigh_pairs`` for a joint of this name."""
        pairs = JointName(joint).pairs
        return {"count": pairs} if pairs != "auto" else {"count": None, **self.model_dump()}
