"""Linear equations of the corrections and tangents of a branch, with all Jacobians or with few.

A corrector (``solvers.corrector``) has one of these solvers as a part. Its linear equations are the
derivative of the residual by unknown and parameter, bordered by a row.
"""

from abc import ABC, abstractmethod
from typing import Any, ClassVar, Generic, TypeVar, cast

import numpy as np

from boltjoint.solvers.equations import (
    Derivative,
    Equations,
    LazyJacobian,
    Matrix,
    Precision,
    Solution,
    Vector,
)
from boltjoint.solvers.newton import (
    KeptFactors,
    NewtonKrylov,
    newton,
    rounding,
    smallest_residual,
    solve,
)
from boltjoint.solvers.step_control import StepControl

#: number of unknowns from which a Jacobian costs more than the products that stand for it
LARGE = 1000

#: residual of the linear equations over their right side: with 1e-3 a step takes more corrections,
#: so that steps become short, and a response takes longer
_TOLERANCE = 1e-5

Linearised = Matrix | Derivative
"""What the linear equations at a solution are made of: its Jacobian, or products with it."""

Linearisation = TypeVar("Linearisation", bound=Linearised)


class LinearSolver(ABC, Generic[Linearisation]):
    """Linear equations at the solutions of a branch, from their linearisation there.

    Parameters
    ----------
    equations, control
        The system, tolerance and number of iterations.
    """

    #: whether determinants are known, and with these the orientation of a branch
    has_determinant: ClassVar[bool]

    def __init__(self, equations: Equations, control: StepControl) -> None:
        self.equations, self.control = equations, control

    @abstractmethod
    def newton(self, x: Vector, p: float) -> tuple[Solution, Linearisation]:
        """Solution at a fixed parameter, and a linearisation there or at its last correction."""

    @abstractmethod
    def linearise(self, derivative: LazyJacobian) -> Linearisation:
        """What the linear equations are made of."""

    @abstractmethod
    def jacobian(self, linearisation: Linearisation) -> Matrix:
        """Jacobian of a linearisation."""

    @abstractmethod
    def smallest_residual(self, x: Vector, linearisation: Linearisation) -> float:
        """The residual that counts as zero."""

    @abstractmethod
    def solve_bordered(
        self,
        x: Vector,
        p: float,
        linearisation: Linearisation,
        weights: Vector,
        border: Vector,
        right: Vector,
        *,
        scale_rows: bool = False,
    ) -> Vector | None:
        """Weighted solution of the derivative bordered by a row; None where it is singular.

        Parameters
        ----------
        x, p, linearisation
            A point, and the equations linearised there.
        weights, border
            Weights of unknown and parameter, and the row, of the weighted unknown.
        right
            Right side, the last entry that of the row.
        scale_rows
            Whether rows are scaled to the length 1 first, where only that of the border has a right
            side.
        """

    def derivative(
        self, x: Vector, p: float, linearisation: Linearisation, weights: Vector
    ) -> Matrix:
        """Derivative of the residual by unknown and parameter, in weighted coordinates."""
        by_parameter = self.equations.parameter_derivative(x, p)
        return np.column_stack([self.jacobian(linearisation), by_parameter]) / weights


class DenseSolver(LinearSolver[Matrix]):
    """A Jacobian wherever the equations are linearised, and its LU factors."""

    has_determinant = True

    def newton(self, x: Vector, p: float) -> tuple[Solution, Matrix]:
        """Solution at a fixed parameter, and the Jacobian at its last correction."""
        return newton(self.equations, x, p, self.control)

    def linearise(self, derivative: LazyJacobian) -> Matrix:
        """The Jacobian."""
        return derivative()

    def jacobian(self, linearisation: Matrix) -> Matrix:
        """The Jacobian itself."""
        return linearisation

    def smallest_residual(self, x: Vector, linearisation: Matrix) -> float:
        """By the tolerance, or the rounding of the residual's own terms."""
        return smallest_residual(self.equations, self.control, x, linearisation)

    def solve_bordered(
        self,
        x: Vector,
        p: float,
        linearisation: Matrix,
        weights: Vector,
        border: Vector,
        right: Vector,
        *,
        scale_rows: bool = False,
    ) -> Vector | None:
        """As of any linear solver."""
        derivative = self.derivative(x, p, linearisation, weights)
        if scale_rows:
            derivative /= np.linalg.norm(derivative, axis=1, keepdims=True)
        return solve(np.vstack([derivative, border]), right)


class KrylovSolver(LinearSolver[Derivative]):
    """GMRES with the factors of an earlier bordered Jacobian (``newton.KeptFactors``).

    The equations give a ``Derivative``, which stands wherever the other solver has a Jacobian.
    """

    #: that takes the factors of a Jacobian at every solution
    has_determinant = False

    def __init__(self, equations: Equations, control: StepControl) -> None:
        super().__init__(equations, control)
        self._factors, self._rounding = KeptFactors(), 0.0

    def newton(self, x: Vector, p: float) -> tuple[Solution, Derivative]:
        """Solution at a fixed parameter, and the derivative there."""
        solution = NewtonKrylov(self.equations, self.control).solve(x, p)
        return solution, self.linearise(self.equations.evaluate(solution.x, p)[1])

    def linearise(self, derivative: LazyJacobian) -> Derivative:
        """The derivative itself."""
        return cast(Derivative, derivative)

    def jacobian(self, linearisation: Derivative) -> Matrix:
        """The Jacobian, evaluated."""
        return linearisation()

    def smallest_residual(self, x: Vector, linearisation: Derivative) -> float:
        """By the tolerance, or the rounding of the residual where the factors are from."""
        return max(self.control.tolerance * self.equations.residual_scale, self._rounding)

    def solve_bordered(
        self,
        x: Vector,
        p: float,
        linearisation: Derivative,
        weights: Vector,
        border: Vector,
        right: Vector,
        *,
        scale_rows: bool = False,
    ) -> Vector | None:
        """As of any linear solver, residuals over their scale instead of rows of the length 1.

        Factors are those of the change that is not weighted, since weights change from one solution
        to the next.
        """
        by_parameter = self.equations.parameter_derivative(x, p)
        scale = np.append(np.full(x.size, self.equations.residual_scale), 1.0)
        row = border * weights

        def along(change: Vector) -> Vector:
            by_change = linearisation.along(change[:-1]) + change[-1] * by_parameter
            return np.append(by_change, row @ change) / scale

        def matrix(precision: Precision) -> Matrix:
            by_unknown = linearisation(precision)
            self._rounding = rounding(by_unknown, x)
            bordered = np.vstack([np.column_stack([by_unknown, by_parameter]), row])
            return bordered / scale[:, None]

        solution = self._factors.solve(along, matrix, right / scale, _TOLERANCE)
        return None if solution is None else solution * weights


def linear_solver(
    equations: Equations, control: StepControl, x: Vector, p: float
) -> LinearSolver[Any]:
    """That with few Jacobians for many unknowns, if the equations give products with them."""
    if x.size < LARGE or not isinstance(equations.evaluate(x, p)[1], Derivative):
        return DenseSolver(equations, control)
    return KrylovSolver(equations, control)
