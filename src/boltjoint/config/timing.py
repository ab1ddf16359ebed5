"""Timing of the solver."""

from boltjoint.config.entries import Entry
from boltjoint.config.types import Count, Positive


class Timing(Entry):
    """Timing of the solver.

    Forward differences are timed too where the source solves: node-to-node joints, ``regions`` and
    their ``elements``, in ``linear`` and ``rdnm-N`` of bases ``free-N``.
    """

    repeats: Count = 3
    """Largest number of timed repeats of each frequency response."""
    time_budget_s: Positive = 0.5
    """Time after which no further repeat begins, summed over the repeats of a response."""
