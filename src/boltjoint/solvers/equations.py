"""Systems r(x, p) = 0 of one parameter, options of the continuation, and solution branches.

Nothing here knows mechanics: a system is what answers the calls of ``Equations``.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

LazyJacobian = Callable[[], Matrix]
"""Evaluates the Jacobian that belongs to a residual, where a correction needs it."""


class Equations(Protocol):
    """A system of equations r(x, p) = 0 with one parameter."""

    residual_scale: float
    """Size of the terms that a residual is compared with."""

    def evaluate(self, x: Vector, p: float) -> tuple[Vector, LazyJacobian]:
        """Residual, and its lazily evaluated Jacobian by x."""

    def parameter_derivative(self, x: Vector, p: float) -> Vector:
        """Derivative of the residual by p."""

    tracked: object = None
    """What mode tracking remembers of the last accepted solution; it may be set back."""

    def accept(self, x: Vector) -> None:
        """Take note of an accepted solution, by which mode tracking continues."""


class Quantity(Protocol):
    """A scalar observed along a branch, whose local maxima are located."""

    def value(self, x: Vector) -> float:
        """The quantity at a solution."""

    def slope(self, x: Vector, dx: Vector) -> float:
        """Its derivative along a direction, or anything of the same sign."""


@dataclass(frozen=True)
class StepControl:
    """Tolerance of the corrector and step-length control.

    Parameters
    ----------
    tolerance
        A residual below this times its scale is zero, and so is one within rounding of its terms.
    first_step, smallest_step, largest_step
        Arc lengths; the first step is no longer than the largest.
    target_iterations
        Corrector iterations at which the step stays as it is; below it grows, above it shrinks.
    maximum_iterations
        Corrector iterations after which a step is retried at half the length.
    maximum_solutions
        Solutions after which a branch is given up.

    Raises
    ------
    ValueError
        If one of them is not positive and finite, iterations or solutions are not whole numbers, or
        the smallest step is not below the first one.
    """

    tolerance: float = 1e-9
    first_step: float = 0.02
    smallest_step: float = 1e-9
    largest_step: float = 0.07
    target_iterations: int = 4
    maximum_iterations: int = 12
    maximum_solutions: int = 5000

    def __post_init__(self) -> None:
        """Refuse options with which no branch can be followed."""
        for name, value in vars(self).items():
            if name in ("target_iterations", "maximum_iterations", "maximum_solutions"):
                checks.whole(name, value, above=0)
            else:
                checks.number(name, value, above=0)
        begin = min(self.first_step, self.largest_step)
        if self.smallest_step >= begin:
            raise ValueError(
                f"smallest_step is {self.smallest_step}: it must be below the first step, {begin}"
            )


class Solution(NamedTuple):
    """A solution on a branch: unknown, parameter, corrector iterations, and whether it solves."""

    x: Vector
    p: float
    iterations: int
    converged: bool
    located: bool = False
    """Whether it is a local maximum that was located."""
    full: bool = True
    """Whether it solves the full equations, not those in a lagging basis."""


@dataclass
class Path:
    """Solutions in the order they were found.

    ``complete`` tells whether the far end of the window was reached; if not, ``reason`` says why.
    """

    solutions: list[Solution] = field(default_factory=list)
    complete: bool = False
    reason: str = ""
