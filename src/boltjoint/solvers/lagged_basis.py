"""Equations in a basis that depends on the response, with their predictor and corrector.

The unknown is expressed in a basis that is updated at least once for each solution, so that its
meaning changes along the branch; solutions are recorded in fixed coordinates. A lagged basis is
that of the last solution or, where it is predictive, of the predicted point. An implicit one is
updated by fixed-point iteration until it belongs to the solution itself. Where there are full
equations, solutions in the basis of the predicted point only predict those of these.

References
----------
B. M. Irons, R. C. Tuck: A version of the Aitken accelerator for computer iteration. International
Journal for Numerical Methods in Engineering 1 (1969) 275-277.
"""

from abc import abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from boltjoint.solvers.corrector import Corrector, Predictor, Step, projection
from boltjoint.solvers.equations import Equations, Quantity, Solution, Vector
from boltjoint.solvers.maxima import Arc, Maxima, Observation
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl


class LaggedEquations(Equations):
    """Equations whose unknown is expressed in a basis that depends on the response."""

    predictive: bool
    """Whether the basis is that of the predicted point, not of the last solution."""

    implicit: bool
    """Whether the basis is updated within a step until it belongs to the solution.

    It is not where the solution only predicts another.
    """

    full_equations: Equations | None
    """In fixed coordinates, where solutions in the basis predict those of these; else None."""

    basis: object
    """In which the unknown is expressed: the state of the equations."""

    def state(self) -> object:
        """The basis."""
        return self.basis

    def restore(self, state: object) -> None:
        """Return to an earlier basis."""
        self.basis = state

    @abstractmethod
    def update(self, q: Vector, p: float) -> None:
        """Make the basis that of a response in fixed coordinates."""

    @abstractmethod
    def from_fixed(self, q: Vector) -> Vector:
        """Projection of a response in fixed coordinates onto the basis."""

    @abstractmethod
    def to_fixed(self, x: Vector) -> Vector:
        """The response in fixed coordinates."""

    @abstractmethod
    def change_from_fixed(self, dq: Vector) -> Vector:
        """Projection of a change of the response."""

    @abstractmethod
    def change_to_fixed(self, dx: Vector) -> Vector:
        """A change of the unknown as one of the response."""


class Origin(NamedTuple):
    """A solution in fixed coordinates from which a step is taken, and its direction."""

    q: Vector
    p: float
    direction: Vector


def _in_basis(corrector: Corrector, equations: LaggedEquations, origin: Origin) -> Predictor:
    """The predictor at an origin in the present basis of equations, whose corrector is given."""
    q, p, direction = origin
    along = np.append(equations.change_from_fixed(direction[:-1]), direction[-1])
    return corrector.predictor_at(equations.from_fixed(q), p, along)


class BasisPrediction:
    """Solutions of the equations in a basis of the predicted point, for the full equations.

    Parameters
    ----------
    equations, control, scale
        As for ``Corrector``.
    """

    def __init__(
        self, equations: LaggedEquations, control: StepControl, scale: Callable[[float], float]
    ) -> None:
        self._equations = equations
        self._corrector = Corrector(equations, control, scale)

    def __call__(self, predictor: Predictor, length: float) -> Vector | None:
        """Weighted offset at a distance from the solution of a predictor; None without one."""
        equations, direction = self._equations, predictor.tangent / predictor.weights
        equations.update(*predictor.at(length * predictor.tangent))
        origin = Origin(predictor.x, predictor.p, direction)
        step = self._corrector.correct(_in_basis(self._corrector, equations, origin), length)
        if step is None:
            return None
        change = equations.to_fixed(step.solution.x) - predictor.x
        return np.append(change, step.solution.p - predictor.p) * predictor.weights


class LaggedCorrector:
    """Predictor and corrector in a basis that depends on the response.

    Parameters
    ----------
    equations, control, scale
        As for ``Corrector``.
    """

    origin: Origin
    predictor: Predictor

    def __init__(
        self, equations: LaggedEquations, control: StepControl, scale: Callable[[float], float]
    ) -> None:
        self.equations, self.control = equations, control
        self.corrector = Corrector(equations, control, scale)
        #: response and parameter of the last basis update
        self._update_point: tuple[Vector, float]

    def start(self, guess: Vector, p: float, sense: float) -> Solution:
        """Solve at a fixed parameter, in a basis updated until the solution changes no more."""
        equations, lagged = self.equations, self.control.lagged
        # a predictive basis is relaxed for the reason given in _iterate
        relaxation = 0.5 if equations.predictive else 1.0
        x, point = equations.from_fixed(guess), guess
        for _ in range(lagged.maximum_start_iterations):
            solution, _ = newton(equations, x, p, self.control)
            q = equations.to_fixed(solution.x)
            point = point + relaxation * (q - point)
            equations.update(point, p)
            x = equations.from_fixed(q)
            change = np.linalg.norm(equations.to_fixed(x) - q)
            if change <= lagged.start_tolerance * np.linalg.norm(q):
                break
        solution = self.solution_at(x, p)
        q = solution.x
        self.origin = Origin(q, p, np.append(np.zeros_like(q), sense))
        self._update_point = point, p
        self.predictor = _in_basis(self.corrector, equations, self.origin)
        return solution

    def solution_at(self, guess: Vector, p: float) -> Solution:
        """Solve in the present basis at a fixed parameter; in fixed coordinates."""
        solution, _ = newton(self.equations, guess, p, self.control)
        return self._to_fixed(solution)

    def correct(self, length: float) -> Step | None:
        """A step in the present basis or, where it is implicit, in that of its solution."""
        step = self.corrector.correct(self.predictor, length)
        if not self.equations.implicit:
            return step
        tolerance = self.control.lagged.tolerance * length
        return self._iterate(step, length, tolerance, self.control.lagged.maximum_iterations)

    def _iterate(
        self, step: Step | None, length: float, tolerance: float, maximum_iterations: int
    ) -> Step | None:
        """Fixed-point iteration on the basis, with Aitken's relaxation factor.

        A solution may change with opposite sign to the point at which its basis is updated, so that
        the iteration without relaxation would oscillate. The factor is determined from the last
        two iterations (Irons and Tuck 1969).
        """
        relaxation, last_gap = 0.5, None
        limits = self.control.lagged.smallest_relaxation, self.control.lagged.largest_relaxation
        for _ in range(maximum_iterations):
            if step is None:
                return None
            q, p = self._update_point
            gap = self.equations.to_fixed(step.solution.x) - q
            if np.linalg.norm(gap) <= tolerance * np.linalg.norm(q + gap):
                return step
            if last_gap is not None and (change := gap - last_gap).any():
                factor = -relaxation * (last_gap @ change) / (change @ change)
                relaxation = float(np.clip(factor, *limits))
            last_gap = gap
            self.update(q + relaxation * gap, p + relaxation * (step.solution.p - p))
            step = self.corrector.correct(self.predictor, length)
        return None

    def advance(self, origin: Origin, ratio: float) -> None:
        """Continue from a solution, with a step of this ratio to the last one."""
        last, self.origin = self.origin, origin
        if self.equations.predictive:
            q, p = origin.q - last.q, origin.p - last.p
            self.update(origin.q + ratio * q, origin.p + ratio * p)
        else:
            self.update(origin.q, origin.p)

    def halve(self) -> None:
        """Move the update point of a predictive basis halfway to the origin."""
        if self.equations.predictive:
            (q, p), origin = self._update_point, self.origin
            self.update((q + origin.q) / 2, (p + origin.p) / 2)

    def update(self, q: Vector, p: float) -> None:
        """Update the basis at a response, and express the predictor in it."""
        self.equations.update(q, p)
        self._update_point = q, p
        self.predictor = _in_basis(self.corrector, self.equations, self.origin)

    def project(self) -> None:
        """Project the predictor onto the branch, which the basis update has moved."""
        projected = projection(self.corrector, self.predictor)
        if projected is not None:
            (x, p, *_), jacobian = projected
            weights, tangent = self.predictor.weights, self.predictor.tangent
            tangent = self.corrector.tangent(x, p, jacobian, weights, tangent / weights)
            self.predictor = Predictor(x, p, weights, tangent)

    def secant(self, step: Step) -> Vector:
        """From the last solution to that of a step, in weighted fixed coordinates."""
        change = self.equations.to_fixed(step.solution.x) - self.origin.q
        by_parameter = (step.solution.p - self.origin.p) * self.predictor.weights[-1]
        return np.append(change * self.predictor.weights[0], by_parameter)

    def origin_of(self, step: Step) -> Origin:
        """The end of a step as origin of the next."""
        direction = self.equations.change_to_fixed(step.offset[:-1])
        q = self.equations.to_fixed(step.solution.x)
        return Origin(q, step.solution.p, np.append(direction, step.offset[-1]))

    def locate_maximum(self, maxima: Maxima, step: Step, length: float) -> Solution | None:
        """The maximum within a step, if the slope in the held basis falls through zero in it."""
        quantity = _InBasis(maxima.quantity, self.equations)
        predictor = self.predictor
        slope = quantity.slope(predictor.x, (predictor.tangent / predictor.weights)[:-1])
        if not slope > 0 >= self.corrector.observation(quantity, predictor, step).slope:
            return None
        highest = maxima.locate(self.corrector.arc(quantity, predictor), slope, length)
        return highest and self._to_fixed(highest)

    def arc_between(self, quantity: Quantity, begin: Origin, end: Origin) -> Arc:
        """The branch from one solution towards the next, each point in the basis of its own."""
        q, p = end.q - begin.q, end.p - begin.p
        weights = self.predictor.weights
        length = float(np.linalg.norm(np.append(q * weights[0], p * weights[-1])))

        def observation_at(distance: float) -> Observation | None:
            state = self.equations.state()
            kept = self._update_point, self.origin, self.predictor
            self.origin, fraction = begin, distance / length
            self.update(begin.q + fraction * q, begin.p + fraction * p)
            step = self._iterate(
                self.corrector.correct(self.predictor, distance),
                distance,
                self.control.lagged.tolerance_at_peak,
                self.control.lagged.maximum_iterations_at_peak,
            )
            solution = step and self._to_fixed(step.solution)
            self.equations.restore(state)
            self._update_point, self.origin, self.predictor = kept
            return solution and Observation(solution, quantity.value(solution.x), np.nan)

        return observation_at

    def _to_fixed(self, solution: Solution) -> Solution:
        return solution._replace(x=self.equations.to_fixed(solution.x), reduced=True)


class _InBasis(NamedTuple):
    """A quantity of the fixed coordinates as a function of the unknown in a basis."""

    quantity: Quantity
    equations: LaggedEquations

    def value(self, x: Vector) -> float:
        return self.quantity.value(self.equations.to_fixed(x))

    def slope(self, x: Vector, dx: Vector) -> float:
        return self.quantity.slope(self.equations.to_fixed(x), self.equations.change_to_fixed(dx))
