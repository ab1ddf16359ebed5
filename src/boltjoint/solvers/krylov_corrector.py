"""Corrector of branches with many unknowns, where few Jacobians serve many solutions.

Corrections and tangents are solved by GMRES with the factors of an earlier bordered Jacobian
(``newton_krylov``).
"""

from dataclasses import dataclass, field

import numpy as np

from boltjoint.solvers.corrector import Corrector, Predictor, Step
from boltjoint.solvers.equations import Derivative, Matrix, Solution, Vector
from boltjoint.solvers.newton import rounding
from boltjoint.solvers.newton_krylov import KeptFactors, NewtonKrylov

#: residual of the linear equations over their right side: with 1e-3 a step takes more corrections,
#: so that steps become short, and a response takes longer
_TOLERANCE = 1e-5


@dataclass
class KrylovCorrector(Corrector):
    """Predictors and corrector of one branch whose equations give a ``Derivative``.

    It stands wherever the other corrector has a Jacobian.
    """

    _factors: KeptFactors = field(init=False, default_factory=KeptFactors)
    _rounding: float = field(init=False, default=0.0)

    def linearise(self, derivative: Derivative) -> Derivative:
        """The derivative itself."""
        return derivative

    def newton(self, x: Vector, p: float) -> tuple[Solution, Derivative]:
        """Solution at a fixed parameter, and the derivative there."""
        solution = NewtonKrylov(self.equations, self.control).solve(x, p)
        return solution, self.equations.evaluate(solution.x, p)[1]

    def smallest_residual(self, x: Vector, jacobian: Derivative) -> float:
        """The residual that counts as zero: its rounding is that where factors are from."""
        return max(self.control.tolerance * self.equations.residual_scale, self._rounding)

    def tangent(
        self, x: Vector, p: float, jacobian: Derivative, weights: Vector, direction: Vector
    ) -> Vector:
        """Unit tangent of the branch in weighted coordinates, in the sense of a direction."""
        along = direction * weights
        along /= np.linalg.norm(along)
        unit = np.zeros(weights.size)
        unit[-1] = 1.0
        tangent = self.solve_bordered(x, p, jacobian, weights, along, unit)
        if tangent is None:  # the branch is normal to the direction
            return along
        return tangent / np.linalg.norm(tangent)

    def orientation(self, predictor: Predictor, step: Step) -> float:
        """Not known, as it takes the factors of a Jacobian at every solution."""
        return 0.0

    def derivative(self, x: Vector, p: float, jacobian: Derivative, weights: Vector) -> Matrix:
        """Derivative of the residual by unknown and parameter, in weighted coordinates."""
        return super().derivative(x, p, jacobian(), weights)

    def solve_bordered(
        self,
        x: Vector,
        p: float,
        jacobian: Derivative,
        weights: Vector,
        border: Vector,
        right: Vector,
    ) -> Vector | None:
        """Weighted solution of the derivative bordered by a row; None where it is singular.

        Residuals are over their scale. Factors are those of the change that is not weighted, since
        weights change from one solution to the next.
        """
        by_parameter = self.equations.parameter_derivative(x, p)
        scale = np.append(np.full(x.size, self.equations.residual_scale), 1.0)
        row = border * weights

        def along(change: Vector) -> Vector:
            by_change = jacobian.along(change[:-1]) + change[-1] * by_parameter
            return np.append(by_change, row @ change) / scale

        def matrix() -> Matrix:
            by_unknown = jacobian()
            self._rounding = rounding(by_unknown, x)
            bordered = np.vstack([np.column_stack([by_unknown, by_parameter]), row])
            return bordered / scale[:, None]

        found = self._factors.solve(along, matrix, right / scale, _TOLERANCE)
        return None if found is None else found * weights
