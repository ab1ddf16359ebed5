"""Friction laws as the configuration and the report know them: words, keys, capabilities.

The laws themselves are in ``friction.laws``. They are compiled; this module is read by every job of
the workflow, so it imports none of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

from boltjoint.names import CONSTANT_NORMAL_LOAD, COULOMB_ELEMENTS

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: label of each direction of motion in the contact in files of modes, in their order: first tangent
#: of a point, which lies along the bar in a half lap, second tangent, and normal, whatever their
#: direction in space
AXES = {"tangential": "x", "lateral": "y", "normal": "z"}

#: end of the name of a quantity that is given per unit of contact area
_PER_AREA = "_per_area"


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
        return self.name.removesuffix(_PER_AREA).replace("_", " ")

    @property
    def key(self) -> str:
        """The key in the file of a case."""
        name = self.name.removesuffix(_PER_AREA)
        return name if self.unit == "1" else f"{name}_{self.unit.replace('/', '_per_')}"

    @property
    def forms(self) -> tuple[Self, ...]:
        """The quantity of each pair, and that per area where a case may give it so."""
        return (self,) if self.per_area is None else (self, self.per_area)


def is_per_area(name: str) -> bool:
    """Whether the name is that of a quantity per area."""
    return name.endswith(_PER_AREA)


def keys_of_pairs(
    keys: Mapping[str, float],
    area: "NDArray",
    surface: "NDArray | None" = None,
    of_surfaces: Mapping[str, Mapping[str, float]] | None = None,
) -> "dict[str, float | NDArray]":
    """Arguments of ``ElementLaw.from_contact``: those per area times the area of each pair.

    Parameters
    ----------
    keys
        By the names of ``ContactKey``, in SI units.
    area
        Of each pair [m2], shape (pairs,).
    surface
        Name of the surface of each pair, shape (pairs,).
    of_surfaces
        By the names of surfaces, the keys whose values replace those of all there, in any form.

    Raises
    ------
    ValueError
        If a quantity is given for each pair and per area, there is no such surface, or it has a
        quantity that not all have.
    """
    import numpy as np  # those who read declarations do without

    from boltjoint import checks

    checks.mapping("keys", keys)
    area = checks.array("area", area, ("pairs",), above=0)
    found = _of_areas(keys, area)
    if not of_surfaces:
        return found
    names = np.broadcast_to("" if surface is None else surface, area.shape)
    checks.mapping("surfaces", of_surfaces)
    for name, own in of_surfaces.items():
        checks.choice("surface", name, np.unique(names).tolist())
        checks.mapping(f"surface {name}", own)
        here = names == name
        for key, value in _of_areas(own, area[here]).items():
            checks.choice(f"key of surface {name}", key, found)
            # in turn: a surface may have values of each pair where all have one
            of_pairs = np.array(np.broadcast_to(found[key], area.shape), dtype=float)
            of_pairs[here] = value
            found[key] = of_pairs
    return found


def _of_areas(keys: Mapping[str, float], area: "NDArray") -> "dict[str, float | NDArray]":
    """Quantities of each pair of these areas, of which some are given per area."""
    found = {}
    for name, value in keys.items():
        of_pair = name.removesuffix(_PER_AREA)
        if of_pair in found:
            raise ValueError(f"{of_pair} is given for each pair and per area: give one of them")
        found[of_pair] = value * area if is_per_area(name) else value
    return found


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


def _stiffness(direction: str) -> ContactKey:
    """Stiffness of the pairs in a direction."""
    name, words = f"{direction}_stiffness", f"{direction.capitalize()} stiffness"
    per_area = ContactKey(
        f"{name}{_PER_AREA}", "N/m3", f"{words} per area: each contact pair has it times its area."
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
