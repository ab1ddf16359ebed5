"""Joints with other values of their elements, natural frequencies and structural damping."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, LossFactor, as_damping
from boltjoint.friction.element_law import ElementLaw
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]

#: parameters beside the quantities of the law
LOSS_FACTOR, FREQUENCY = "loss_factor", "natural_frequency"


@dataclass(frozen=True)
class JointParameters:
    """A joint as a function of parameters.

    Names are quantities of its law: ``tangential_stiffness`` and ``slip_force`` are the sums over
    all elements, which keep their shares; ratios as ``chi`` or ``friction_coefficient`` are the
    same for all. ``slip_force[2]`` is that of the elements on contact point 2 alone, counted from
    0. ``loss_factor`` is that of the structure, ``natural_frequency[1]`` that of a mode without
    contact [Hz], counted from 1.

    Parameters
    ----------
    joint
        With any values.
    damping
        Of the structure, unless a parameter is its loss factor.
    """

    joint: Joint
    damping: Damping | float = 0.0

    def __post_init__(self) -> None:
        """Refuse joints without elements."""
        checks.instance("joint", self.joint, Joint)
        checks.instance("law of the joint", self.joint.law, ElementLaw)
        object.__setattr__(self, "damping", as_damping(self.damping))

    def __call__(self, values: Mapping[str, float]) -> tuple[Joint, Damping]:
        """The joint and the damping of the structure with these values.

        Raises
        ------
        ValueError
            If a name is none of a parameter, or a value is out of range.
        """
        law, damping = self.joint.law, self.damping
        frequency = self.joint.natural_frequency.copy()
        changed: dict[str, Array] = {}
        for name, value in values.items():
            quantity, place = _parsed(name)
            if name == LOSS_FACTOR:
                damping = LossFactor(value)
            elif quantity == FREQUENCY and place is not None and 1 <= place <= frequency.size:
                frequency[place - 1] = value
            elif quantity in law.quantities and self._is_point(place):
                own = changed.get(quantity, law.quantity(quantity))
                changed[quantity] = self._with(own, quantity, place, value)
            else:
                allowed = (*law.quantities, LOSS_FACTOR, f"{FREQUENCY}[1]")
                raise ValueError(
                    f"parameter {name} is none of the joint; there are {', '.join(allowed)}, "
                    f"and of contact points 0 to {self.joint.points - 1} as {allowed[0]}[0]"
                )
        law = law.with_quantities(changed) if changed else law
        return replace(self.joint, law=law, natural_frequency=frequency), damping

    def _is_point(self, place: int | None) -> bool:
        return place is None or place in self.joint.law.point_of_element

    def _with(self, own: Array, quantity: str, place: int | None, value: float) -> Array:
        """The quantity of all elements with another value of some."""
        law = self.joint.law
        some = np.ones(own.size, bool) if place is None else law.point_of_element == place
        unit, _ = law.quantities[quantity]
        new = own.copy()
        new[some] = value if unit == "1" else own[some] * (value / own[some].sum())
        return new


def _parsed(name: str) -> tuple[str, int | None]:
    """Quantity and place of a name."""
    found = re.fullmatch(r"(\w+?)(?:\[(\d+)\])?", name)
    return (
        (name, None) if found is None else (found[1], None if found[2] is None else int(found[2]))
    )
