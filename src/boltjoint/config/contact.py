"""Contact of a case: the friction law and its coefficients."""

from typing import Annotated, Literal

from pydantic import Field

from boltjoint.config.entries import Entry
from boltjoint.config.types import Positive


class CoulombContact(Entry):
    """Contact of one friction law."""

    law: str
    """The friction law: constant or variable normal load."""
    tangential_stiffness_N_per_m: Positive
    """Tangential stiffness of each contact pair."""
    friction_coefficient: Positive
    """Coulomb friction coefficient: slip force over normal load."""


class ConstantLoadContact(CoulombContact):
    """Friction elements of the pairs under load, whose normal load stays that of the preload."""

    law: Literal["constant"]
    """The friction law: constant or variable normal load."""


class VariableLoadContact(CoulombContact):
    """Friction elements of all pairs, whose normal load changes as they close and open."""

    law: Literal["variable"]
    """The friction law: constant or variable normal load."""
    normal_stiffness_N_per_m: Positive
    """Normal stiffness of each contact pair."""


Contact = Annotated[ConstantLoadContact | VariableLoadContact, Field(discriminator="law")]
