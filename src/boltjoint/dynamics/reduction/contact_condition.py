"""The contact and damping of a case, which contact-adapted bases are made for."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import TypeAdapter

from boltjoint import checks
from boltjoint.config.contact import Contact
from boltjoint.config.entries import Entry
from boltjoint.damping import Damping, as_damping
from boltjoint.friction.combined import elements_of_pairs
from boltjoint.friction.element_law import ContactPairs
from boltjoint.joint.model import Joint
from boltjoint.joint.node_to_node import connect_pairs

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContactCondition:
    """A contact and damping that a basis is made for.

    Parameters
    ----------
    contact
        As of a case; ``of`` takes its keys.
    damping
        Of the structure.
    """

    contact: Contact
    damping: Damping

    def __post_init__(self) -> None:
        """Refuse what is no contact or damping."""
        checks.instance("contact", self.contact, Entry)
        checks.instance("damping", self.damping, Damping)

    @classmethod
    def of(cls, contact: Mapping[str, Any], damping: Damping | float) -> Self:
        """The condition of a case by the keys of its contact.

        Parameters
        ----------
        contact
            Keys of ``contact`` in a case, as ``law`` and ``tangential_stiffness_N_per_m``.
        damping
            Of the structure; a number is a loss factor.

        Returns
        -------
        ContactCondition
            For ``find_pod_modes``.

        Raises
        ------
        ValueError
            If a key is missing, not known or out of range.
        """
        checks.mapping("contact", contact)
        return cls(TypeAdapter(Contact).validate_python(contact), as_damping(damping))

    def tangential_stiffness(self, area: Array, surface: NDArray[np.str_]) -> Array:
        """Of pairs of these areas on these surfaces [N/m], shape (pairs,)."""
        nothing = np.zeros(area.shape)
        every = ContactPairs(nothing + 1, nothing, np.zeros((area.size, 3)), area, surface)
        elements, pairs = elements_of_pairs(every, **self.contact.options)
        of_pairs = np.empty(area.shape)
        of_pairs[pairs[elements.point_of_element]] = elements.tangential_stiffness
        return of_pairs

    def connect(self, preload: xr.Dataset, modes: xr.Dataset) -> Joint:
        """Node-to-node joint of modes under a preload."""
        return connect_pairs(modes, preload, **self.contact.options)

    @property
    def needs_second_tangents(self) -> bool:
        """Whether its law needs motion along the second tangents of the contact."""
        return "lateral" in self.contact.declaration.directions
