"""Predictor and corrector on spheres around the solutions of a branch.

The next solution lies at the distance of the step length from the last one (Crisfield 1981; eq.
2.39 to 2.42 of the thesis), so the branch may turn back in the parameter. Distances are measured
relative to the last solution, because a resonance spans orders of magnitude:
``|dx|^2 / |x|^2 + (dp / scale)^2``.

References
----------
M. A. Crisfield: A fast incremental/iterative solution procedure that handles "snap-through".
Computers and Structures 13 (1981) 55-62.
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: sections 2.1.4 and 2.1.5.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from boltjoint.solvers.equations import Equations, Matrix, Quantity, Solution, Vector
from boltjoint.solvers.linear_solvers import DenseSolver, Linearised, LinearSolver
from boltjoint.solvers.maxima import Arc, Observation
from boltjoint.solvers.newton import smallest_residual, solve
from boltjoint.solvers.step_control import StepControl

#: distances from a solution below this share of the largest are relative to the latter: only where
#: the response vanishes, so that peaks are the same with half or twice
SMALLEST_SHARE = 1e-3


class Predictor(NamedTuple):
    """A solution from which a step is taken: weights of distances, and the unit tangent."""

    x: Vector
    p: float
    weights: Vector
    tangent: Vector

    def at(self, offset: Vector) -> tuple[Vector, float]:
        """Unknown and parameter at a weighted offset."""
        change = offset / self.weights
        return self.x + change[:-1], self.p + float(change[-1])


class Step(NamedTuple):
    """A solution on a sphere, linearised there, and the unweighted offset from the center."""

    solution: Solution
    jacobian: Linearised
    offset: Vector


class Corrector:
    """Predictors and corrector of one branch.

    Parameters
    ----------
    equations, control
        The system and its tolerances.
    scale
        Change of the parameter, by the parameter, that counts as much as doubling the unknown.
    linear
        Solver of its linear equations; by default that with all Jacobians.
    """

    def __init__(
        self,
        equations: Equations,
        control: StepControl,
        scale: Callable[[float], float],
        linear: LinearSolver[Any] | None = None,
    ) -> None:
        self.equations, self.control, self.scale = equations, control, scale
        self.linear: LinearSolver[Any] = (
            DenseSolver(equations, control) if linear is None else linear
        )
        #: norm of the unknown along the branch so far
        self.largest_norm = 0.0

    def predictor(self, x: Vector, p: float, jacobian: Linearised, direction: Vector) -> Predictor:
        """The predictor from a solution, its tangent along an unweighted direction."""
        size = float(np.linalg.norm(x))
        self.largest_norm = max(self.largest_norm, size)
        size = max(size, SMALLEST_SHARE * self.largest_norm) or 1.0
        weights = np.append(np.full_like(x, 1 / size), 1 / self.scale(p))
        return Predictor(x, p, weights, self.tangent(x, p, jacobian, weights, direction))

    def predictor_at(self, x: Vector, p: float, direction: Vector) -> Predictor:
        """The same where no Jacobian is known yet."""
        _, jacobian_at = self.equations.evaluate(x, p)
        return self.predictor(x, p, jacobian_at(), direction)

    def tangent(
        self, x: Vector, p: float, jacobian: Linearised, weights: Vector, direction: Vector
    ) -> Vector:
        """Unit tangent of the branch in weighted coordinates, in the sense of a direction.

        The thesis takes the sense from the sign of det J (2.47). Bordering the derivatives with
        the direction is equivalent, and needs no determinant that over- or underflows.
        """
        along = direction * weights
        unit = np.zeros(weights.size)
        unit[-1] = 1.0
        border = along / np.linalg.norm(along)
        tangent = self.linear.solve_bordered(x, p, jacobian, weights, border, unit, scale_rows=True)
        if tangent is None:  # the branch is normal to the direction
            tangent = along
        return tangent / np.linalg.norm(tangent)

    def orientation(self, predictor: Predictor, step: Step) -> float:
        """Orientation of the branch at the end of a step, in the sense of the step.

        Along a branch it stays the same (``corners``), through turning points and corners too: a
        step that changes it ends on another part of the branch, or is past a crossing of branches.
        It is 0 where it is not known.
        """
        if not self.linear.has_determinant:
            return 0.0
        x, p = step.solution.x, step.solution.p
        derivative = self.linear.derivative(x, p, step.jacobian, predictor.weights)
        return orientation_of(derivative, step.offset * predictor.weights)

    def correct(
        self,
        predictor: Predictor,
        radius: float,
        direction: Vector | None = None,
        *,
        update_jacobian: bool = False,
    ) -> Step | None:
        """Solve on a sphere around the solution of a predictor.

        Parameters
        ----------
        predictor, radius
            Center and radius.
        direction
            Unit direction of the predicted point; by default the tangent, from which the solution
            must not deviate by more than 60 degrees.
        update_jacobian
            Whether the Jacobian is evaluated at the solution; else it is that of the last
            correction.

        Returns
        -------
        Step or None
            None where the corrector fails or diverges, or the solution deviates from the tangent.
        """
        offset = radius * (predictor.tangent if direction is None else direction)
        jacobian = None
        for iteration in range(self.control.maximum_iterations + 1):
            x, p = predictor.at(offset)
            residual, jacobian_at = self.equations.evaluate(x, p)
            if jacobian is None:
                jacobian = self.linear.linearise(jacobian_at)
            sphere = offset @ offset / radius - radius
            limit = self.linear.smallest_residual(x, jacobian)
            if np.linalg.norm(residual) <= limit and abs(sphere) <= 1e-3 * radius:
                if direction is None and self._deviates(predictor, offset, radius):
                    return None
                solution = Solution(x, p, iteration, True)
                jacobian = self.linear.linearise(jacobian_at) if update_jacobian else jacobian
                return Step(solution, jacobian, offset / predictor.weights)
            if iteration > 0:
                jacobian = self.linear.linearise(jacobian_at)
            border, right = 2 * offset / radius, np.append(residual, sphere)
            weights = predictor.weights
            correction = self.linear.solve_bordered(x, p, jacobian, weights, border, right)
            if correction is None or np.linalg.norm(correction) > 2 * radius:
                return None
            offset = offset - correction
        return None

    def correct_from(self, predictor: Predictor, radius: float, predicted: Vector) -> Step | None:
        """Solve on a sphere, from where a predicted offset points.

        None where the corrector fails, or the solution is another one: it deviates from the tangent
        as in ``correct``, or is far from what was predicted.
        """
        predicted = radius / float(np.linalg.norm(predicted)) * predicted
        step = self.correct(predictor, radius, predicted / radius)
        if step is None:
            return None
        offset = step.offset * predictor.weights
        correction = np.linalg.norm(offset - predicted)
        is_far = correction > self.control.lagged.largest_correction * radius
        return None if is_far or self._deviates(predictor, offset, radius) else step

    def _deviates(self, predictor: Predictor, offset: Vector, radius: float) -> bool:
        """Whether a weighted offset encloses more than the largest angle with the tangent."""
        return bool(offset @ predictor.tangent < self.control.smallest_cosine * radius)

    def with_tangent_at_solution(self, predictor: Predictor) -> Predictor:
        """The predictor with the tangent of the Jacobian at its own solution."""
        _, jacobian_at = self.equations.evaluate(predictor.x, predictor.p)
        x, p, weights, tangent = predictor
        jacobian = self.linear.linearise(jacobian_at)
        tangent = self.tangent(x, p, jacobian, weights, tangent / weights)
        return predictor._replace(tangent=tangent)

    def observation(self, quantity: Quantity, predictor: Predictor, step: Step) -> Observation:
        """A quantity and its slope along the branch at the end of a step."""
        x, p, weights = step.solution.x, step.solution.p, predictor.weights
        tangent = self.tangent(x, p, step.jacobian, weights, step.offset)
        slope = quantity.slope(x, (tangent / weights)[:-1])
        return Observation(step.solution, quantity.value(x), slope)

    def arc(self, quantity: Quantity, predictor: Predictor) -> Arc:
        """Observations of a quantity along the branch by the distance from a solution."""

        def observation_at(distance: float) -> Observation | None:
            step = self.correct(predictor, distance, update_jacobian=True)
            return step and self.observation(quantity, predictor, step)

        return observation_at


def orientation_of(derivative: Matrix, direction: Vector) -> float:
    """Sign of the determinant of the derivative bordered by a direction."""
    scaled = derivative / np.linalg.norm(derivative, axis=1, keepdims=True)
    return float(np.linalg.slogdet(np.vstack([scaled, direction]))[0])


def projection(corrector: Corrector, predictor: Predictor) -> tuple[Solution, Matrix] | None:
    """Solution and Jacobian in the plane normal to the tangent of a predictor beside the branch."""
    control, offset = corrector.control, np.zeros_like(predictor.tangent)
    for iteration in range(control.maximum_iterations):
        x, p = predictor.at(offset)
        residual, jacobian_at = corrector.equations.evaluate(x, p)
        jacobian = jacobian_at()
        limit = smallest_residual(corrector.equations, control, x, jacobian)
        if np.linalg.norm(residual) <= limit:
            return Solution(x, p, iteration, True), jacobian
        derivative = corrector.linear.derivative(x, p, jacobian, predictor.weights)
        correction = solve(np.vstack([derivative, predictor.tangent]), np.append(residual, 0.0))
        if correction is None:
            return None
        offset = offset - correction
    return None
