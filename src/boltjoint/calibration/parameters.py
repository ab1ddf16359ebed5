"""Parameters of a calibration: bounds, scale, start and prior of each."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from boltjoint import checks

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
        return tuple(each.name for each in self.parameters)

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
