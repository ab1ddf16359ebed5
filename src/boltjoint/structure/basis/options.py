"""Numerical options of the snapshots of a contact-adapted basis and of their decomposition."""

from dataclasses import dataclass

from boltjoint import checks
from boltjoint.options import Options


@dataclass(frozen=True)
class PODOptions(Options):
    """Snapshots by stick patterns, and weights that balance the errors of all.

    Fewer or more modes, and half or twice of any other, move the peaks of three bolts under
    constant load in ``enriched-40`` (1, 10 and 50 N) by at most 1.1e-4 in frequency and 2.2e-3 in
    amplitude. ``enriched-auto`` has from 24 to 64 vectors then, all within the tolerances by their
    estimate.

    Parameters
    ----------
    first_modes
        Modes of each contact that the first basis holds, at most ``free_modes``. Later bases are
        made from its errors.
    load_shares
        Shares of the load of the pairs that stick around the bolts in the stick patterns: from most
        of the contact down to the pressure under the heads.
    iterations
        Decompositions after which the weights are final; the best is kept.
    least_weight
        Share of the mean weight below which none falls, so that what is held well can come back.

    Raises
    ------
    ValueError
        If there are no modes, iterations or shares, a share is not between 0 and 1, or the least
        weight is not between 0 and 1.
    """

    first_modes: int = 8
    load_shares: tuple[float, ...] = (0.75, 0.4, 0.15)
    iterations: int = 40
    least_weight: float = 1e-3

    def __post_init__(self) -> None:
        """Refuse options without a basis, a pattern or a decomposition."""
        checks.whole("first_modes", self.first_modes, at_least=1)
        checks.whole("iterations", self.iterations, at_least=1)
        checks.number("least_weight", self.least_weight, above=0, below=1)
        checks.numbers("load_shares", self.load_shares)
        checks.array("load_shares", self.load_shares, ("shares",), at_most=1)
