"""Contact-adapted basis: accuracy and numerical options of the bases ``enriched-N``."""

from boltjoint.config.entries import Entry
from boltjoint.config.types import Count, Fraction, ModesCount, Positive, Problems


class ContactAdaptedBasis(Entry):
    """Accuracy and numerical options of the bases ``enriched-N`` and ``enriched-auto``.

    One basis of each size serves all cases of an assembly: it is made for the contact and damping
    of each of them, and for those of all cases where none uses the assembly. A case that is added
    with another contact or damping therefore makes new bases.
    """

    frequency_tolerance: Fraction = 1e-3
    """Relative error of the frequency of a peak. ``enriched-auto`` has the fewest vectors with
    which no peak of the first resonance is estimated to have a larger one."""
    amplitude_tolerance: Fraction = 1e-2
    """The same of its amplitude."""
    pattern_tolerance: Fraction = 2e-3
    """Relative error of resonances while a part of the contact sticks, against which that of peaks
    is weighed."""
    resonances: ModesCount = 2
    """Resonances whose motion the bases hold, from the first; at most ``free_modes``."""
    free_modes: ModesCount = 12
    """Modes without contact among the candidates."""
    maximum_vectors: ModesCount = 128
    """Vectors of the largest basis; ``enriched-N`` has the first N of them."""
    balanced_vectors: ModesCount = 40
    """Vectors with which all errors are made equally small, or ``maximum_vectors`` if fewer."""
    states: Count = 24
    """States of each backbone from which the basis is made."""
    adaptations: Count = 6
    """Bases that are each made from the errors of the one before, at most: no more are made once
    the dual-weighted residuals of all vectors are within the tolerances."""
    trial_step: Count = 8
    """Step of the numbers of vectors whose errors are estimated."""
    lowest_amplitude: Positive = 1.0
    """Amplitude at which backbones begin, over that at which the first pair slips."""
    highest_amplitude: Positive = 300.0
    """Amplitude at which they end, over that at which half of the pairs slip: all slip there."""
    smallest_growth: Fraction = 0.04
    """Smallest derivative of the logarithm of the force by that of the amplitude of its peak. Where
    it is less, near a fold of the peaks, the amplitude at a force has no limit of accuracy."""

    def conflicts(self) -> Problems:
        if self.resonances > self.free_modes:
            yield ("resonances",), f"must be at most free_modes, {self.free_modes}"
