"""Components of a periodic motion or force: the one grammar of their names, and their places.

A motion is ``bias + sum over h of sin_h sin(h w t) + cos_h cos(h w t)``. Its components are named
``bias``, ``sin``, ``cos``, ``sin2``, ``cos2`` and so on. Arrays hold them along one axis, in the
order of ``Components``.
"""

import math
from collections.abc import Iterable
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

BIAS, SIN, COS = "bias", "sin", "cos"


class Harmonic(NamedTuple):
    """Number of a harmonic, and the places of its sine and cosine among the components."""

    number: int
    sin: int
    cos: int


class Components(tuple[str, ...]):
    """Names of components, in their order.

    >>> components = Components(("bias", "sin", "cos", "sin3", "cos3"))
    >>> components.bias, components.sin(3), components.highest
    (0, 3, 3)
    """

    @classmethod
    def up_to(cls, highest: int, *, is_odd: bool = False) -> Self:
        """Those of all harmonics up to a number, with the bias; or of the odd ones, without."""
        numbers = range(1, highest + 1, 2 if is_odd else 1)
        oscillating = [f"{part}{h if h > 1 else ''}" for h in numbers for part in (SIN, COS)]
        return cls(oscillating if is_odd else (BIAS, *oscillating))

    @cached_property
    def number(self) -> NDArray[np.int64]:
        """Number of the harmonic of each component, 0 of the bias."""
        return np.array([0 if name == BIAS else int(name[len(SIN) :] or 1) for name in self])

    @cached_property
    def is_sine(self) -> NDArray[np.bool_]:
        """Whether each component is a sine."""
        return np.array([name.startswith(SIN) for name in self])

    @property
    def highest(self) -> int:
        """Number of the highest harmonic."""
        return int(self.number.max())

    @property
    def has_bias(self) -> bool:
        """Whether there is a mean."""
        return BIAS in self

    @property
    def bias(self) -> int:
        """Place of the bias."""
        return self.index(BIAS)

    def sin(self, harmonic: int = 1) -> int:
        """Place of the sine of a harmonic."""
        return self.index(f"{SIN}{harmonic if harmonic > 1 else ''}")

    def cos(self, harmonic: int = 1) -> int:
        """Place of the cosine of a harmonic."""
        return self.index(f"{COS}{harmonic if harmonic > 1 else ''}")

    @cached_property
    def harmonics(self) -> tuple[Harmonic, ...]:
        """All harmonics in the order of their sines."""
        numbers = self.number[self.is_sine].tolist()
        return tuple(Harmonic(h, self.sin(h), self.cos(h)) for h in numbers)

    def rows(self, x: NDArray) -> NDArray:
        """What stands in a vector one component after another, shape (components, ...)."""
        return x.reshape(len(self), -1)

    def of_each(self, matrix: NDArray[np.float64]) -> NDArray[np.float64]:
        """A matrix that acts on every component alike, shape (components * n,) * 2."""
        count, n = len(self), len(matrix)
        blocks = np.zeros((count, n, count, n))
        for place in range(count):
            blocks[place, :, place] = matrix
        return blocks.reshape(count * n, count * n)

    def quarter_later(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Where each component of the motion a quarter of each period later stands, and its sign.

        With ``phi = s + i c`` that is ``i phi``: the derivative by the phase over the number. That
        of a bias vanishes.
        """
        place, sign = np.arange(len(self)), np.zeros(len(self))
        for _, s, c in self.harmonics:
            place[[s, c]], sign[[s, c]] = (c, s), (-1.0, 1.0)
        return place, sign

    def later(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """A motion a quarter of each period later, shape (components, ...)."""
        place, sign = self._quarter_later
        return sign[:, None] * self.rows(x)[place]

    def turned(self, x: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
        """A motion later by an angle of the first harmonic [rad], shape (components, ...)."""
        turn = (self.number * angle)[:, None]
        return np.cos(turn) * self.rows(x) + np.sin(turn) * self.later(x)

    @cached_property
    def _quarter_later(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        return self.quarter_later()

    @cached_property
    def phase_derivative(self) -> NDArray[np.float64]:
        """Matrix that gives the components of the derivative by the phase, as the function."""
        return phase_derivative(self.number, self.is_sine)

    def at_samples(self, samples: int) -> NDArray[np.float64]:
        """Value of each component at equally spaced times of a period, (components, samples)."""
        # whole periods are subtracted as integers, without rounding
        turns = np.outer(self.number, np.arange(samples)) % samples / samples
        return np.where(self.is_sine[:, None], np.sin(2 * np.pi * turns), np.cos(2 * np.pi * turns))


def highest_harmonic(motions: xr.Dataset) -> int:
    """The highest harmonic of the motions in the file of a response or a backbone."""
    # a backbone names those beyond the first alone
    further = motions["component"].to_numpy().tolist() if "component" in motions.coords else []
    return Components((SIN, COS, *further)).highest


def harmonics_of_level(response: xr.Dataset, level: int) -> int:
    """The highest harmonic of the solutions at a level, counted from 0, of ``response.nc``."""
    if "response_harmonics" in response:
        return int(response["response_harmonics"][level])
    return highest_harmonic(response)


def in_words(highest: Iterable[float]) -> str:
    """The number of harmonics of some motions; empty where it is known of none.

    >>> in_words([1, math.nan]), in_words([3]), in_words([9, 3]), in_words([])
    ('one harmonic', '3 harmonics', '3 to 9 harmonics', '')
    """
    numbers = [round(number) for number in highest if not math.isnan(number)]
    if not numbers:
        return ""
    fewest, most = min(numbers), max(numbers)
    if fewest < most:
        return f"{fewest} to {most} harmonics"
    return f"{most} harmonics" if most > 1 else "one harmonic"


def phase_derivative(number: NDArray[np.int64], is_sine: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Matrix that gives the components of the derivative of a motion by its phase.

    That of ``s sin(h x) + c cos(h x)`` is ``-h c sin(h x) + h s cos(h x)``.

    Parameters
    ----------
    number, is_sine
        Number of the harmonic of each component, and whether it is a sine, shape (components,).
    """
    of_same = (number[:, None] == number) & (is_sine[:, None] != is_sine)
    return of_same * np.where(is_sine, 1.0, -1.0) * number
