"""Parameters of a calibration: bounds, scale, start and prior; joints by their values."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from boltjoint import checks
from boltjoint.damping import Damping, LossFactor, as_damping
from boltjoint.friction.element_law import ElementLaw
from boltjoint.joint.derived import with_elements
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]


class Prior(NamedTuple):
    """What is known of a parameter beforehand.

    ``deviation`` is a standard deviation in the scale of the parameter: of its logarithm where it
    is logarithmic.
    """

    mean: float
    deviation: float


@dataclass(frozen=True)
class Parameter:
    """A number of the model that is fitted.

    Parameters
    ----------
    name
        As the model knows it.
    low, high
        Bounds.
    logarithmic
        Whether steps and errors are of its logarithm; the bounds are positive then.
    start
        First guess; by default starts are spread over the bounds.
    prior
        What is known beforehand.

    Raises
    ------
    ValueError
        If bounds are reversed, or start or prior are out of range.
    """

    name: str
    low: float
    high: float
    logarithmic: bool = True
    start: float | None = None
    prior: Prior | None = None

    def __post_init__(self) -> None:
        """Refuse bounds that hold nothing."""
        checks.instance("name of a parameter", self.name, str)
        low = checks.number(f"low of {self.name}", self.low)
        high = checks.number(f"high of {self.name}", self.high)
        checks.flag(f"logarithmic of {self.name}", self.logarithmic)
        if not low < high:
            raise ValueError(
                f"bounds of {self.name} are reversed: low is {low:g} and high {high:g}"
            )
        if self.logarithmic and low <= 0:
            raise ValueError(f"low of {self.name} is {low:g}: a logarithm needs it above 0")
        if self.start is not None:
            checks.number(f"start of {self.name}", self.start, at_least=low, at_most=high)
        if self.prior is not None:
            checks.instance(f"prior of {self.name}", self.prior, Prior)
            checks.number(f"prior mean of {self.name}", self.prior.mean, at_least=low, at_most=high)
            checks.number(f"prior deviation of {self.name}", self.prior.deviation, above=0)

    def scaled(self, value: float) -> float:
        """The value in its scale."""
        return float(np.log(value)) if self.logarithmic else float(value)

    def value(self, scaled: float) -> float:
        """The value of a number in its scale."""
        return float(np.exp(scaled)) if self.logarithmic else float(scaled)


@dataclass(frozen=True)
class ParameterSpace:
    """All parameters of a calibration, in their scales.

    Raises
    ------
    ValueError
        If there is none, or a name stands twice.
    """

    parameters: tuple[Parameter, ...]

    def __post_init__(self) -> None:
        """Refuse names that stand twice."""
        checks.sequence("parameters", self.parameters, Parameter)
        object.__setattr__(self, "parameters", tuple(self.parameters))
        if not self.parameters:
            raise ValueError("parameters is empty: there must be one at least")
        for name in self.names:
            if self.names.count(name) > 1:
                raise ValueError(f"parameter {name} stands {self.names.count(name)} times")

    @property
    def names(self) -> tuple[str, ...]:
        """In their order."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest in their scales, each (parameters,)."""
        low, high = np.array([[p.scaled(p.low), p.scaled(p.high)] for p in self.parameters]).T
        return low, high

    def values(self, scaled: Array) -> dict[str, float]:
        """Values by name."""
        return {p.name: p.value(x) for p, x in zip(self.parameters, scaled, strict=True)}

    def scaled(self, values: Sequence[float]) -> Array:
        """Values in their scales, shape (parameters,)."""
        return np.array([p.scaled(x) for p, x in zip(self.parameters, values, strict=True)])

    def starts(self, count: int, seed: int) -> Array:
        """Points of a Sobol sequence within the bounds, (count, parameters); the first is given.

        A parameter with a start has it in the first point, in the others it is spread too.
        """
        low, high = self.bounds
        power = int(np.ceil(np.log2(max(count, 2))))
        points = qmc.Sobol(low.size, seed=seed).random_base2(power)[:count]
        starts = low + (high - low) * points
        for n, parameter in enumerate(self.parameters):
            if parameter.start is not None:
                starts[0, n] = parameter.scaled(parameter.start)
        return starts

    @property
    def priors(self) -> Array:
        """Mean and deviation of each prior, NaN where there is none, shape (2, parameters)."""
        return np.array([p.prior or (np.nan, np.nan) for p in self.parameters]).T

    def prior_residual(self, scaled: Array) -> Array:
        """Deviation of each parameter with a prior from its mean, over its deviation."""
        return np.array(
            [
                (x - p.scaled(p.prior.mean)) / p.prior.deviation
                for p, x in zip(self.parameters, scaled, strict=True)
                if p.prior is not None
            ]
        )

    def prior_jacobian(self) -> Array:
        """Derivative of ``prior_residual``, (parameters with a prior, parameters)."""
        weight = [0.0 if p.prior is None else 1 / p.prior.deviation for p in self.parameters]
        return np.diag(weight)[np.array(weight) > 0]


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
        law, damping = self.joint.contact.element_law, as_damping(self.damping)
        frequency = self.joint.natural_frequency.copy()
        changed: dict[str, Array] = {}
        for name, value in values.items():
            quantity, place = _parsed(name)
            if name == LOSS_FACTOR:
                damping = LossFactor(value)
            elif quantity == FREQUENCY and place is not None and 1 <= place <= frequency.size:
                frequency[place - 1] = value
            elif quantity in law.quantities and self._is_point(place):
                own = changed[quantity] if quantity in changed else law.quantity(quantity)
                changed[quantity] = self._with(own, quantity, place, value)
            else:
                allowed = (*law.quantities, LOSS_FACTOR, f"{FREQUENCY}[1]")
                raise ValueError(
                    f"parameter {name} is none of the joint; there are {', '.join(allowed)}, "
                    f"and of contact points 0 to {self.joint.points - 1} as {allowed[0]}[0]"
                )
        law = law.with_quantities(changed) if changed else law
        return with_elements(self.joint, law, frequency), damping

    def _is_point(self, place: int | None) -> bool:
        return place is None or place in self.joint.law.point_of_element

    def _with(self, own: Array, quantity: str, place: int | None, value: float) -> Array:
        """The quantity of all elements with another value of some."""
        law = self.joint.contact.element_law
        some = slice(None) if place is None else law.point_of_element == place
        unit, _ = law.quantities[quantity]
        new = own.copy()
        new[some] = value if unit == "1" else own[some] * (value / own[some].sum())
        return new


@cache
def _parsed(name: str) -> tuple[str, int | None]:
    """Quantity and place of a name."""
    match = re.fullmatch(r"(\w+?)(?:\[(\d+)\])?", name)
    return (
        (name, None) if match is None else (match[1], None if match[2] is None else int(match[2]))
    )
