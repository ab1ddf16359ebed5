"""Regions of a case: how the contact pairs are divided, and how a region moves."""

from typing import Literal

from boltjoint.config.entries import Entry
from boltjoint.config.types import Fraction


class Regions(Entry):
    """Division of the contact pairs into regions."""

    division: Literal["equal-load", "equal-middle-load"] = "equal-load"
    """Bands ``regions=N`` along the bar of equal shares of the normal load, or of equal shares of
    the pressure along the middle of the width, as in the source under variable load; ``clusters=N``
    are of pairs of similar motion."""
    motion: Literal["mean", "load-weighted"] = "mean"
    """Motion of a band: mean of its pairs as in the source, or their mean weighted by normal load,
    which keeps the friction dissipation in full slip."""
    tolerance: Fraction = 0.01
    """Largest relative error of the resonances, over states of slip, with which ``regions=auto``
    and ``clusters=auto`` take the fewest regions, of at most 64, before any response is solved.
    Errors of amplitude are larger than these, which are of frequency."""
