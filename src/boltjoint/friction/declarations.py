"""Friction laws as the configuration and the report know them: words, keys, capabilities.

The laws themselves are in ``friction.laws``. They are compiled; this module is read by every job of
the workflow, so it imports none of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from boltjoint.names import CONSTANT_NORMAL_LOAD, COULOMB_ELEMENTS

#: axis of each direction of motion in the contact, in their order: along the bar, along its width,
#: and across the contact
AXES = {"tangential": "x", "lateral": "y", "normal": "z"}


@dataclass(frozen=True)
class ContactKey:
    """A quantity of the contact pairs that a case gives.

    ``name`` is that of the argument of ``FrictionLaw.from_contact``, with the unit that of the key;
    ``limits`` has ``gt``, ``ge``, ``lt`` and ``le``.
    """

    name: str
    unit: str
    meaning: str
    limits: Mapping[str, float] = field(default_factory=lambda: {"gt": 0})

    @property
    def key(self) -> str:
        """The key in the file of a case."""
        return self.name if self.unit == "1" else f"{self.name}_{self.unit.replace('/', '_per_')}"


@dataclass(frozen=True)
class LawDeclaration:
    """What is known of a law without its forces.

    Parameters
    ----------
    name
        Value of ``law`` in a case and in ``joint.nc``.
    label
        The law in pages and legends.
    meaning
        Sentence on the elements of the contact pairs.
    keys
        What a case gives beside ``law``; None of a law that only reductions make.
    directions, components
        Directions of motion that the law needs, and its harmonic coefficients of one harmonic.
    capabilities
        What it has of the needs of reductions (``names.Reduction``).
    shape_parameters
        Quantities without unit that shape the loops of an element, for tables.
    relative_time
        Time of a force with its tangent, over that of an element under constant normal load.
    has_closed_form
        Whether its forces of one harmonic are known without AFT.
    """

    name: str
    label: str
    meaning: str
    keys: tuple[ContactKey, ...] | None
    directions: tuple[str, ...] = ("tangential",)
    components: tuple[str, ...] = ("sin", "cos")
    capabilities: tuple[str, ...] = (CONSTANT_NORMAL_LOAD, COULOMB_ELEMENTS)
    shape_parameters: tuple[str, ...] = ()
    relative_time: float = 1.0
    has_closed_form: bool = True

    def components_of(self, harmonics: int) -> int:
        """Number of harmonic coefficients; without bias the force has no even harmonics."""
        return 1 + 2 * harmonics if "bias" in self.components else 2 * ((harmonics + 1) // 2)


_TANGENTIAL_STIFFNESS = ContactKey(
    "tangential_stiffness", "N/m", "Tangential stiffness of each contact pair."
)
_FRICTION_COEFFICIENT = ContactKey(
    "friction_coefficient", "1", "Coulomb friction coefficient: slip force over normal load."
)

CONSTANT = LawDeclaration(
    name="constant",
    label="constant normal load",
    meaning="Friction elements of the pairs under load, whose normal load stays that of the "
    "preload.",
    keys=(_TANGENTIAL_STIFFNESS, _FRICTION_COEFFICIENT),
)
VARIABLE = LawDeclaration(
    name="variable",
    label="variable normal load",
    meaning="Friction elements of all pairs, whose normal load changes as they close and open.",
    keys=(
        _TANGENTIAL_STIFFNESS,
        _FRICTION_COEFFICIENT,
        ContactKey("normal_stiffness", "N/m", "Normal stiffness of each contact pair."),
    ),
    directions=("tangential", "normal"),
    components=("bias", "sin", "cos"),
    capabilities=(COULOMB_ELEMENTS,),
)
TABULATED = LawDeclaration(
    name="tabulated",
    label="constant normal load, tabulated",
    meaning="Friction elements of a point as one table of their describing function.",
    keys=None,
)
IWAN = LawDeclaration(
    name="iwan",
    label="four-parameter Iwan elements",
    meaning="Four-parameter Iwan elements (Segalman 2005) of the pairs under load, whose normal "
    "load stays that of the preload.",
    keys=(
        _TANGENTIAL_STIFFNESS,
        _FRICTION_COEFFICIENT,
        ContactKey(
            "chi",
            "1",
            "Exponent of the distribution of slip displacements: in microslip the dissipation "
            "grows with the amplitude to the power 3 + chi.",
            {"gt": -1, "le": 0},
        ),
        ContactKey(
            "beta",
            "1",
            "Stiffness of the part that slips last, all at once, over that of the rest.",
            {"ge": 0},
        ),
    ),
    capabilities=(CONSTANT_NORMAL_LOAD,),
    shape_parameters=("chi", "beta"),
    relative_time=4.0,
)

_ALONG_AND_ACROSS = "along the bar and along its width"
UNCOUPLED_CONSTANT = replace(
    CONSTANT,
    name="uncoupled-constant",
    label="uncoupled friction under constant normal load",
    meaning=f"Two friction elements of each pair under load, {_ALONG_AND_ACROSS}, that slip on "
    "their own; the normal load stays that of the preload.",
    directions=("tangential", "lateral"),
    capabilities=(CONSTANT_NORMAL_LOAD,),
    relative_time=2.0,
)
UNCOUPLED_VARIABLE = replace(
    VARIABLE,
    name="uncoupled-variable",
    label="uncoupled friction under variable normal load",
    meaning=f"Two friction elements of each pair, {_ALONG_AND_ACROSS}, that slip on their own "
    "under one normal load, which changes as the pair closes and opens.",
    directions=("tangential", "lateral", "normal"),
    capabilities=(),
    relative_time=2.0,
)
COUPLED_CONSTANT = replace(
    UNCOUPLED_CONSTANT,
    name="coupled-constant",
    label="coupled friction under constant normal load",
    meaning=f"Friction elements of the pairs under load whose force {_ALONG_AND_ACROSS} has a "
    "circular limit; the normal load stays that of the preload. Needs ``solver.friction_force: "
    "aft``.",
    relative_time=10.0,
    has_closed_form=False,
)
COUPLED_VARIABLE = replace(
    UNCOUPLED_VARIABLE,
    name="coupled-variable",
    label="coupled friction under variable normal load",
    meaning=f"Friction elements of all pairs whose force {_ALONG_AND_ACROSS} has a circular limit; "
    "the normal load changes as they close and open. Needs ``solver.friction_force: aft``.",
    relative_time=10.0,
    has_closed_form=False,
)

#: by name
DECLARATIONS = {
    each.name: each
    for each in (
        CONSTANT,
        VARIABLE,
        IWAN,
        TABULATED,
        UNCOUPLED_CONSTANT,
        UNCOUPLED_VARIABLE,
        COUPLED_CONSTANT,
        COUPLED_VARIABLE,
    )
}
