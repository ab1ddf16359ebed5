"""Friction laws as the configuration and the report know them: words, keys, capabilities.

The laws themselves are in ``friction.registry``. They are compiled; this module is read by every
job of the workflow, so it imports none of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Self

from boltjoint.names import CONSTANT_NORMAL_LOAD, COULOMB_ELEMENTS
from boltjoint.other_packages import WithOtherPackages

#: label of each direction of motion in the contact in files of modes, in their order: first tangent
#: of a point, which lies along the bar in a half lap, second tangent, and normal, whatever their
#: direction in space
AXES = {"tangential": "x", "lateral": "y", "normal": "z"}

#: of the name of a law that combines several, between their names
AND = " + "

#: end of the name of a quantity that is given per unit of contact area
PER_AREA = "_per_area"


@dataclass(frozen=True)
class ContactKey:
    """A quantity of the contact pairs that a case gives.

    ``name`` is that of the argument of ``ElementLaw.from_contact``, with the unit that of the key;
    ``limits`` has ``gt``, ``ge``, ``lt`` and ``le``. ``per_area`` is the quantity per unit of area
    that may be given in its place; its name ends in ``_per_area``, which its key leaves out.
    """

    name: str
    unit: str
    meaning: str
    limits: Mapping[str, float] = field(default_factory=lambda: {"gt": 0})
    per_area: Self | None = None

    @property
    def words(self) -> str:
        """The quantity, whether of a pair or per area."""
        return self.name.removesuffix(PER_AREA).replace("_", " ")

    @property
    def key(self) -> str:
        """The key in the file of a case."""
        name = self.name.removesuffix(PER_AREA)
        unit = self.unit.replace("/", "_per_").replace(" ", "_")
        return name if self.unit == "1" else f"{name}_{unit}"

    @property
    def forms(self) -> tuple[Self, ...]:
        """The quantity of each pair, and that per area where a case may give it so."""
        return (self,) if self.per_area is None else (self, self.per_area)


def is_per_area(name: str) -> bool:
    """Whether the name is that of a quantity per area."""
    return name.endswith(PER_AREA)


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
    limit_of
        Name of the law under variable normal load which it is without normal stiffness.
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
    limit_of: str | None = None

    @property
    def case_keys(self) -> tuple[ContactKey, ...]:
        """The ``keys``, none of a law that only reductions make."""
        return self.keys or ()

    def components_of(self, harmonics: int) -> int:
        """Number of harmonic coefficients; without bias the force has no even harmonics."""
        return 1 + 2 * harmonics if "bias" in self.components else 2 * ((harmonics + 1) // 2)


def _stiffness(direction: str) -> ContactKey:
    """Stiffness of the pairs in a direction."""
    name, words = f"{direction}_stiffness", f"{direction.capitalize()} stiffness"
    per_area = ContactKey(
        f"{name}{PER_AREA}", "N/m3", f"{words} per area: each contact pair has it times its area."
    )
    return ContactKey(name, "N/m", f"{words} of each contact pair.", per_area=per_area)


_TANGENTIAL_STIFFNESS = _stiffness("tangential")
_FRICTION_COEFFICIENT = ContactKey(
    "friction_coefficient", "1", "Coulomb friction coefficient: slip force over normal load."
)

CONSTANT = LawDeclaration(
    name="constant",
    label="constant normal load",
    meaning="Friction elements of the pairs under load, whose normal load stays that of the "
    "preload.",
    keys=(_TANGENTIAL_STIFFNESS, _FRICTION_COEFFICIENT),
    limit_of="variable",
)
VARIABLE = LawDeclaration(
    name="variable",
    label="variable normal load",
    meaning="Friction elements of all pairs, whose normal load changes as they close and open.",
    keys=(
        _TANGENTIAL_STIFFNESS,
        _FRICTION_COEFFICIENT,
        _stiffness("normal"),
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

KELVIN_VOIGT = LawDeclaration(
    name="kelvin-voigt",
    label="constant normal load beside a Kelvin–Voigt layer",
    meaning="Friction elements of the pairs under load, whose normal load stays that of the "
    "preload, each beside a viscoelastic layer: a spring with a dashpot.",
    keys=(
        _TANGENTIAL_STIFFNESS,
        _FRICTION_COEFFICIENT,
        _stiffness("layer"),
        ContactKey(
            "layer_damping",
            "N s/m",
            "Viscous damping of the layer of each contact pair.",
            per_area=ContactKey(
                f"layer_damping{PER_AREA}",
                "N s/m3",
                "Viscous damping of the layer per area: each contact pair has it times its area.",
            ),
        ),
    ),
    capabilities=(CONSTANT_NORMAL_LOAD,),
    relative_time=2.0,
)

_ALONG_AND_ACROSS = "along both tangents (the bar and its width in a half lap)"
UNCOUPLED_CONSTANT = replace(
    CONSTANT,
    name="uncoupled-constant",
    label="uncoupled friction under constant normal load",
    meaning=f"Two friction elements of each pair under load, {_ALONG_AND_ACROSS}, that slip on "
    "their own; the normal load stays that of the preload.",
    directions=("tangential", "lateral"),
    capabilities=(CONSTANT_NORMAL_LOAD,),
    relative_time=2.0,
    limit_of="uncoupled-variable",
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
    limit_of="coupled-variable",
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


def combined(laws: Sequence[LawDeclaration]) -> LawDeclaration:
    """What is known of a joint of these laws, each on surfaces of its own; one alone is itself."""
    laws = list({law.name: law for law in laws}.values())
    if len(laws) == 1:
        return laws[0]
    directions = tuple(axis for axis in AXES if any(axis in law.directions for law in laws))
    has_bias = any("bias" in law.components for law in laws)
    # those without bias are evaluated by the law they are the limit of
    closed = [law.has_closed_form and (not has_bias or _knows_bias(law)) for law in laws]
    return LawDeclaration(
        name=AND.join(law.name for law in laws),
        label=f"{', '.join(law.label for law in laws[:-1])} and {laws[-1].label}",
        meaning=" ".join(law.meaning for law in laws),
        keys=None,
        directions=directions,
        components=("bias", "sin", "cos") if has_bias else ("sin", "cos"),
        capabilities=tuple(
            able for able in laws[0].capabilities if all(able in law.capabilities for law in laws)
        ),
        relative_time=max(law.relative_time for law in laws),
        has_closed_form=all(closed),
    )


def _knows_bias(law: LawDeclaration) -> bool:
    return "bias" in law.components or law.limit_of is not None


#: entry points by which other packages have laws (``friction.registry``)
GROUP = "boltjoint.laws"


def _of_module(module: ModuleType) -> LawDeclaration:
    """The declaration of the law of another package."""
    return module.DECLARATION


#: of the laws of this package, by name
OWN_DECLARATIONS = {
    law.name: law
    for law in (
        CONSTANT,
        VARIABLE,
        IWAN,
        KELVIN_VOIGT,
        TABULATED,
        UNCOUPLED_CONSTANT,
        UNCOUPLED_VARIABLE,
        COUPLED_CONSTANT,
        COUPLED_VARIABLE,
    )
}

#: by name, those of other packages once they are asked for
DECLARATIONS = WithOtherPackages(OWN_DECLARATIONS, GROUP, _of_module)
