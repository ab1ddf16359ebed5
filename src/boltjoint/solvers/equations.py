"""Systems r(x, p) = 0 with one parameter, options of the continuation, and solution branches.

Nothing here depends on mechanics: a system is any object with the methods of ``Equations``.
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
"""Lazily evaluated Jacobian: called where a correction needs the derivative of a residual."""


class Equations(Protocol):
    """A system of equations r(x, p) = 0 with one parameter."""

    residual_scale: float
    """Size of the terms to which a residual is compared."""

    def evaluate(self, x: Vector, p: float) -> tuple[Vector, LazyJacobian]:
        """Residual and its lazily evaluated Jacobian with respect to x."""

    def parameter_derivative(self, x: Vector, p: float) -> Vector:
        """Derivative of the residual with respect to p."""

    def accept(self, x: Vector) -> None:
        """Update the state by an accepted solution."""

    def state(self) -> object:
        """What depends on the solutions accepted before, as modes that are tracked; else None."""

    def restore(self, state: object) -> None:
        """Return to an earlier state."""


class Quantity(Protocol):
    """A scalar observed along a branch, whose local maxima are located."""

    def value(self, x: Vector) -> float:
        """The quantity at a solution."""

    def slope(self, x: Vector, dx: Vector) -> float:
        """Directional derivative of the quantity, or a number of the same sign."""


@dataclass(frozen=True)
class StepControl:
    """Tolerance of the corrector and step-length control.

    Parameters
    ----------
    tolerance
        Relative to the residual's scale; a residual within rounding of its terms has converged too.
    first_step, smallest_step, largest_step
        Arc lengths; the first step is no longer than the largest.
    target_iterations
        Corrector iterations at which the step length is kept; with fewer it grows, with more it
        shrinks.
    maximum_iterations
        Corrector iterations after which a step is retried at half the length.
    maximum_solutions
        Solutions after which the continuation of a branch stops.

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
        """Refuse options that allow no continuation."""
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
    """A solution on a branch: unknown, parameter, number of iterations, whether it converged."""

    x: Vector
    p: float
    iterations: int
    converged: bool
    located: bool = False
    """Whether it is a local maximum found by event location."""
    reduced: bool = False
    """Whether it solves equations projected onto a reduced basis, not the full equations."""


@dataclass
class SolutionBranch:
    """Solutions along a branch in their order.

    ``complete`` tells whether the far end of the window was reached; if not, ``reason`` says why.
    """

    solutions: list[Solution] = field(default_factory=list)
    complete: bool = False
    reason: str = ""
