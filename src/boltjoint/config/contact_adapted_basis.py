"""Contact-adapted basis: contact, resonances and slip that the bases enriched-N are made for."""

from boltjoint.config.entries import Entry
from boltjoint.config.types import Count, ModesCount, Positive, Problems


class ContactAdaptedBasis(Entry):
    """Contact, resonances and slip that the bases ``enriched-N`` are made for.

    One basis of each size serves all cases of an assembly. It is most accurate for what it was made
    for; the more vectors, the less that matters.
    """

    contact_stiffness_N_per_m: Positive = 1e8
    """Stiffness of each contact pair, along the bar and across the contact."""
    friction_coefficient: Positive = 0.1
    """Coulomb friction coefficient; it decides whether pairs slip before they open."""
    loss_factor: Positive = 0.002
    """Structural loss factor, relative to which snapshots are weighted by their friction."""
    free_modes: ModesCount = 12
    """Modes without contact among the candidates."""
    resonances: ModesCount = 2
    """Resonances whose motion the bases hold, from the first; at most ``free_modes``."""
    slip_levels: Count = 14
    """Levels by which the slip fraction grows from none to all of the load; more levels span more
    vectors."""
    maximum_vectors: ModesCount = 80
    """Vectors of the largest basis; ``enriched-N`` has the first N of them."""

    def conflicts(self) -> Problems:
        if self.resonances > self.free_modes:
            yield ("resonances",), f"must be at most free_modes, {self.free_modes}"
