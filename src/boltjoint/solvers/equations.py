"""Systems r(x, p) = 0 with one parameter, and solution branches.

Nothing here depends on mechanics: a system is any object with the methods of ``Equations``.
"""

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

LazyJacobian = Callable[[], Matrix]
"""Lazily evaluated Jacobian: called where a correction needs the derivative of a residual."""

Precision = type[np.floating]
"""Type of the numbers of a matrix: single where its factors only precondition."""


@dataclass(frozen=True, slots=True)
class Derivative:
    """Derivative of a residual: called, its Jacobian; or its product with a change, without it."""

    jacobian: Callable[[Precision], Matrix]
    along: Callable[[Vector], Vector]

    def __call__(self, precision: Precision = np.float64) -> Matrix:
        """The Jacobian."""
        return self.jacobian(precision)


class Equations(Protocol):
    """A system of equations r(x, p) = 0 with one parameter.

    One that does not depend on the solutions accepted before keeps the last three methods.
    """

    residual_scale: float
    """Size of the terms to which a residual is compared."""

    @abstractmethod
    def evaluate(self, x: Vector, p: float) -> tuple[Vector, LazyJacobian]:
        """Residual and its lazily evaluated Jacobian with respect to x."""

    @abstractmethod
    def parameter_derivative(self, x: Vector, p: float) -> Vector:
        """Derivative of the residual with respect to p."""

    def accept(self, x: Vector) -> None:
        """Update the state by an accepted solution."""
        return None

    def state(self) -> object:
        """What depends on the solutions accepted before, as modes that are tracked; else None."""
        return None

    def restore(self, state: object) -> None:
        """Return to an earlier state."""
        return None


class Quantity(Protocol):
    """A scalar observed along a branch, whose local maxima are located."""

    @abstractmethod
    def value(self, x: Vector) -> float:
        """The quantity at a solution."""

    @abstractmethod
    def slope(self, x: Vector, dx: Vector) -> float:
        """Directional derivative of the quantity, or a number of the same sign."""


class Solution(NamedTuple):
    """A solution on a branch: unknown, parameter, number of iterations, whether it converged."""

    x: Vector
    p: float
    iterations: int
    converged: bool
    located: bool = False
    """Whether it is a local maximum found by event location."""
    reduced: bool = False
    """Whether it solves equations projected onto a reduced basis, or was predicted by these."""


@dataclass
class SolutionBranch:
    """Solutions along a branch in their order.

    ``complete`` tells whether it comes to its end, that of the window or, where no more is wanted,
    behind a peak; if not, ``reason`` says why.
    """

    solutions: list[Solution] = field(default_factory=list)
    complete: bool = False
    reason: str = ""
