"""Convergence study: bases and numbers of regions that are compared with converged ones."""

from boltjoint.config.entries import Entry
from boltjoint.config.types import ComparedModalBasis, Count, Distinct, Joint, Positive, Problems
from boltjoint.names import REFERENCE

#: resonances of the structure by which bases are compared; none can have fewer vectors
COMPARED_RESONANCES = 2


class Convergence(Entry):
    """Bases and numbers of regions that are compared with converged ones beside the cases.

    Peaks of the first resonance are compared, with analytic friction forces and one harmonic
    whatever ``solver`` says.
    """

    bases: Distinct[tuple[ComparedModalBasis, ...]] = ()
    """Bases in which the resonances of every assembly, with parts of its contact stuck, and the
    peaks of every case are found; the others are compared with the last, which is ``enriched-N``.
    No table if empty."""
    regions: Distinct[tuple[Count, ...]] = ()
    """Numbers of regions whose peaks are compared with those of all contact pairs, by division, for
    every case solved in an enriched basis; at most the contact pairs on one side of the centre line
    and on it. No table if empty."""
    reductions: Distinct[tuple[Joint, ...]] = ()
    """Joints whose peaks and times are compared with those of all contact pairs, for every case
    solved in an enriched basis whose friction law they can have. No table if empty."""

    time_integration_N: Distinct[tuple[Positive, ...]] = ()
    """Forces at which the converged peak of the largest basis ``enriched-N`` is integrated in time,
    of each case those among its ``forces_N``, and found in the last of ``bases`` too where that
    has more vectors. It takes a minute or two each. No table if empty."""

    def conflicts(self) -> Problems:
        if self.bases and not self.bases[-1].is_contact_adapted:
            yield ("bases", len(self.bases) - 1), "must be enriched-N: all are compared with it"
        for index, joint in enumerate(self.reductions):
            if joint == REFERENCE[0]:
                yield ("reductions", index), "must not be node-to-node: all are compared with it"
