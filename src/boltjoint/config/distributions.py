"""Values of a key that varies in a sweep: lists, ranges and distributions."""

from collections.abc import Mapping
from math import sqrt
from statistics import NormalDist
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Discriminator, Tag

from boltjoint.config.entries import Entry
from boltjoint.config.types import (
    Count,
    Number,
    NumberOfKey,
    Positive,
    PositiveOfKey,
    Problems,
    Several,
)

Array = NDArray[np.float64]

#: share of the designs that may lie below or above what is checked of a distribution
_TAIL = 1e-6


class Range(Entry):
    """Values between two bounds."""

    lowest: NumberOfKey
    """Lowest value."""
    highest: NumberOfKey
    """Highest value."""
    number: Count | None = None
    """Number of values in a grid, from the lowest to the highest; none in samples."""

    @property
    def extremes(self) -> tuple[float, float]:
        """Lowest and highest value."""
        return self.lowest, self.highest

    def conflicts(self) -> Problems:
        if self.lowest >= self.highest:
            yield ("highest",), f"must be greater than the lowest value, {self.lowest:g}"


class Linear(Range):
    """Evenly spaced values of a grid, or a uniform distribution."""

    kind: Literal["linear"]
    """How the values are distributed."""

    def quantile(self, share: Array) -> Array:
        """The values below which these shares of all designs lie."""
        return self.lowest + (self.highest - self.lowest) * share


class Logarithmic(Range):
    """Values in a grid of equal ratios, or a uniform distribution of the logarithm."""

    kind: Literal["log"]
    """How the values are distributed."""
    lowest: PositiveOfKey
    """Lowest value."""

    def quantile(self, share: Array) -> Array:
        """As of ``Linear``."""
        return self.lowest * (self.highest / self.lowest) ** share


class Normal(Entry):
    """Normal distribution."""

    kind: Literal["normal"]
    """How the values are distributed."""
    mean: NumberOfKey
    """Mean value."""
    standard_deviation: PositiveOfKey
    """Standard deviation."""

    @property
    def extremes(self) -> tuple[float, float]:
        """Values that one design in a million lies below or above."""
        low, high = map(NormalDist(self.mean, self.standard_deviation).inv_cdf, (_TAIL, 1 - _TAIL))
        return low, high

    def quantile(self, share: Array) -> Array:
        """As of ``Linear``."""
        return self.mean + self.standard_deviation * _normal_quantile(share)


class Lognormal(Entry):
    """Distribution of values whose logarithm is normal, as of stiffness and friction."""

    kind: Literal["lognormal"]
    """How the values are distributed."""
    mean: PositiveOfKey
    """Mean value."""
    coefficient_of_variation: Positive
    """Standard deviation over the mean."""

    @property
    def extremes(self) -> tuple[float, float]:
        """As of ``Normal``."""
        low, high = self.quantile(np.array([_TAIL, 1 - _TAIL]))
        return float(low), float(high)

    def quantile(self, share: Array) -> Array:
        """As of ``Linear``."""
        variance = np.log1p(self.coefficient_of_variation**2)
        return self.mean * np.exp(sqrt(variance) * _normal_quantile(share) - variance / 2)


class Triangular(Entry):
    """Triangular distribution, of which the bounds and the likeliest value are known."""

    kind: Literal["triangular"]
    """How the values are distributed."""
    lowest: NumberOfKey
    """Lowest value."""
    likeliest: NumberOfKey
    """Value of the highest density."""
    highest: NumberOfKey
    """Highest value."""

    @property
    def extremes(self) -> tuple[float, float]:
        """Lowest and highest value."""
        return self.lowest, self.highest

    def quantile(self, share: Array) -> Array:
        """As of ``Linear``."""
        width, rise, fall = (
            self.highest - self.lowest,
            self.likeliest - self.lowest,
            self.highest - self.likeliest,
        )
        rising = self.lowest + np.sqrt(share * width * rise)
        return np.where(
            share * width <= rise, rising, self.highest - np.sqrt((1 - share) * width * fall)
        )

    def conflicts(self) -> Problems:
        if self.lowest >= self.highest:
            yield ("highest",), f"must be greater than the lowest value, {self.lowest:g}"
        elif not self.lowest <= self.likeliest <= self.highest:
            yield (
                ("likeliest",),
                f"must lie between the bounds, {self.lowest:g} and {self.highest:g}",
            )


#: by their words
DISTRIBUTIONS: dict[str, type[Entry]] = {
    "linear": Linear,
    "log": Logarithmic,
    "normal": Normal,
    "lognormal": Lognormal,
    "triangular": Triangular,
}


def _form(value: object) -> str | None:
    if isinstance(value, Mapping):
        return value.get("kind")
    if isinstance(value, Entry):
        return getattr(value, "kind", None)
    return "list" if isinstance(value, list | tuple) else None


*_BEFORE, _LAST = DISTRIBUTIONS
Values = Annotated[
    Annotated[Several[Number], Tag("list")]
    | Annotated[Linear, Tag("linear")]
    | Annotated[Logarithmic, Tag("log")]
    | Annotated[Normal, Tag("normal")]
    | Annotated[Lognormal, Tag("lognormal")]
    | Annotated[Triangular, Tag("triangular")],
    Discriminator(
        _form,
        custom_error_type="no_values",
        custom_error_message="must be a list of numbers, or have the kind "
        f"{', '.join(_BEFORE)} or {_LAST}",
    ),
]


def _normal_quantile(share: Array) -> Array:
    # imported here, since every job reads this module
    from scipy.special import ndtri

    return ndtri(share)
