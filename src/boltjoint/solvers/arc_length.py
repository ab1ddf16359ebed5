"""Arc-length continuation of r(x, p) = 0 over a parameter window, with step-length control.

A branch is followed by the predictor and corrector of ``solvers.corrector`` past turning points
and corners. A step is repeated at half the length where the corrector fails, the branch turns by
more than a right angle, or the orientation changes, so that the step ends on another part of the
branch; else its length follows the number of corrector iterations.

References
----------
R. Seydel: Practical Bifurcation and Stability Analysis. Springer, third edition, 2010.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from boltjoint.solvers.corners import Alternative, continuations, is_same_exit
from boltjoint.solvers.corrector import Corrector, Predictor, Step
from boltjoint.solvers.equations import Equations, Quantity, Solution, SolutionBranch, Vector
from boltjoint.solvers.linear_solvers import linear_solver
from boltjoint.solvers.maxima import Maxima
from boltjoint.solvers.step_control import CORNER_STEP, TURNING_STEP, StepControl
from boltjoint.solvers.tracer import Tracer

Prediction = Callable[[Predictor, float], Vector | None]
"""Weighted offset of a predicted solution from the last one, at about a distance; None without."""

#: solutions on other continuations from corners of a complete branch, or as many as it has
_MOST_OTHERS = 300

#: relative difference of two maxima that are the same within their location
_HIGHER = 1e-6


def trace(
    equations: Equations,
    start: Vector,
    window: tuple[float, float],
    control: StepControl,
    *,
    scale: float | Callable[[float], float],
    maximise: Quantity | None = None,
    begin: float | None = None,
    prediction: Prediction | None = None,
) -> SolutionBranch:
    """Follow a solution branch from one end of a parameter window to the other.

    Parameters
    ----------
    equations
        The system; ``accept`` is called after every accepted solution.
    start
        Initial guess of the unknown at ``begin``.
    window
        Parameter where the branch starts and where it ends, in ascending or descending order.
    control
        Step lengths and corrector limits.
    scale
        Change of the parameter that counts as much as doubling the unknown; a function of the
        parameter where it varies.
    maximise
        A quantity whose local maxima are located and added to the branch.
    begin
        Parameter of the start, within the window; by default the first end of the window.
    prediction
        Where corrections start; by default, and where that leads to no solution, on the tangent.

    Returns
    -------
    SolutionBranch
        With all solutions up to where the branch ended. ``complete`` is false, and ``reason`` says
        why, where that is not the end of the window; nothing is raised.
    """
    begin = window[0] if begin is None else begin
    scale = scale if callable(scale) else lambda _, constant=scale: constant
    solver = linear_solver(equations, control, start, begin)
    corrector = Corrector(equations, control, scale, solver)
    branch, maxima = SolutionBranch(), None
    if maximise is not None:
        arc = partial(corrector.arc, maximise)
        maxima = Maxima(branch, maximise, lambda at, _: arc(at), control.peak_tolerance)
    tracer = CornerTracer(corrector, window, branch, maxima, prediction)
    tracer.follow(start, begin)
    tracer.follow_others()
    return branch


class CornerTracer(Tracer):
    """Continuation past turning points and corners.

    Where a corner has several continuations, that of the smallest turn is followed first; where
    it does not reach the end of the window, the run returns to the last such corner and follows the
    next. A branch that leaves a corner twice in the same direction is closed, and does not reach
    it either.

    Parameters
    ----------
    corrector
        Corrector of the branch.
    window, branch
        As for ``Tracer``.
    maxima
        Location of maxima, whose origins are predictors.
    prediction
        As for ``trace``.
    """

    def __init__(
        self,
        corrector: Corrector,
        window: tuple[float, float],
        branch: SolutionBranch,
        maxima: Maxima | None = None,
        prediction: Prediction | None = None,
    ) -> None:
        super().__init__(corrector.control, window, branch, maxima)
        self.corrector, self._prediction = corrector, prediction
        self._predictor: Predictor
        self._secant: Vector | None = None
        #: of the branch in the sense of travel; 0 before the first step
        self._orientation = 0.0
        self._alternatives: list[Alternative] = []
        self._first_branch: SolutionBranch | None = None
        self._count = 0
        #: solutions beyond corners, with the tangent there, and whether the last is one before
        self._exits: list[Predictor] = []
        self._is_closed = False

    @property
    def predictor(self) -> Predictor:
        """Predictor at the last solution."""
        return self._predictor

    @property
    def count(self) -> int:
        """Number of accepted solutions, on all continuations from corners."""
        return self._count

    def start(self, x: Vector, p: float) -> bool:
        """Solve at the start by Newton's method; whether it converged."""
        solution, jacobian = self.corrector.linear.newton(x, p)
        if not solution.converged:
            self.branch.solutions.append(solution)
            return self.stop("no solution found at the start of the window")
        self.accept(Step(solution, jacobian, np.append(np.zeros_like(x), self.sense)), 0.0)
        return True

    def accept(self, step: Step, length: float) -> None:
        """Add the solution of a step to the branch; the length is 0 at the start."""
        self._count += 1
        self.branch.solutions.append(step.solution)
        self._predictor = self._at_end(step)
        self.corrector.equations.accept(step.solution.x)
        self._secant = step.offset if length else None
        if self.maxima is not None:
            self.maxima.sample(self.predictor, length)

    def next_step(self) -> tuple[Step | None, str]:
        """The next step, unless the branch is closed by it; else the reason why none is."""
        step = self._next()
        if step is None:
            return None, "no solution found near the last one"
        if self._is_closed:
            return None, "the branch closes before the end of the window"
        return step, ""

    def _next(self) -> Step | None:
        """The next step, halved until the corrector converges."""
        control, updated = self.control, False
        # at least one length is below each limit, whatever the smallest step
        corner, corner_step = (
            max(length, 2 * control.smallest_step) for length in (TURNING_STEP, CORNER_STEP)
        )
        while self.step_length >= control.smallest_step:
            step = self._correct()
            if step is None and not updated:
                self._predictor = self.corrector.with_tangent_at_solution(self.predictor)
                updated = True
                continue
            if step is None and self.step_length <= corner_step:
                step = self._pass_corner()
            if step is not None and (self.step_length <= corner or not self._turns_back(step)):
                if self._keeps_orientation(step):
                    return step
                if self.step_length <= corner_step:
                    return self._cross(step)
            self.step_length *= 0.5
        return None

    def _correct(self) -> Step | None:
        """The solution at the step length from the last one; None where the corrector fails."""
        predicted = self._prediction and self._prediction(self.predictor, self.step_length)
        if predicted is not None:
            step = self.corrector.correct_from(self.predictor, self.step_length, predicted)
            if step is not None:
                return step._replace(solution=step.solution._replace(reduced=True))
        return self.corrector.correct(self.predictor, self.step_length)

    def _keeps_orientation(self, step: Step) -> bool:
        """Whether the orientation at the end of a step is that of the branch.

        It is that of the last correction first, and is found again at the solution if it differs.
        """
        orientation = self.corrector.orientation(self.predictor, step)
        if self._orientation == 0:
            self._orientation = orientation
        if orientation * self._orientation >= 0:
            return True
        solution = step.solution
        _, jacobian_at = self.corrector.equations.evaluate(solution.x, solution.p)
        step = step._replace(jacobian=self.corrector.linear.linearise(jacobian_at))
        return self.corrector.orientation(self.predictor, step) * self._orientation >= 0

    def _cross(self, step: Step) -> Step:
        """The step that keeps the orientation where a short one changes it; else this one.

        Beyond a crossing of two branches the orientation is the opposite one.
        """
        self._predictor = self.corrector.with_tangent_at_solution(self.predictor)
        kept = self._pass_corner()
        if kept is None:
            self._orientation = -self._orientation
            return step
        return kept

    def _turns_back(self, step: Step) -> bool:
        """Whether the secant direction has turned by more than a right angle in a step."""
        if self._secant is None:
            return False
        weights = self.predictor.weights
        return float((step.offset * weights) @ (self._secant * weights)) < 0

    def _pass_corner(self) -> Step | None:
        """The step of the smallest turn beyond a corner; others are kept in reserve."""
        steps = continuations(self.corrector, self.predictor, self.step_length, self._orientation)
        branch, state = SolutionBranch([*self.branch.solutions]), self.corrector.equations.state()
        at_corner = self.step_length, state, self._orientation, self._exits
        self._alternatives += [
            Alternative(branch, step, *at_corner) for step in reversed(steps[1:])
        ]
        if not steps:
            return None
        leaving = self._at_end(steps[0])
        self._is_closed = any(is_same_exit(leaving, before) for before in self._exits)
        self._exits = [*self._exits, leaving]
        return steps[0]

    def _at_end(self, step: Step) -> Predictor:
        """The predictor at the end of a step."""
        (x, p, *_), jacobian, direction = step
        return self.corrector.predictor(x, p, jacobian, direction)

    def return_from_dead_end(self, reason: str) -> bool:
        """Follow the next continuation from the last corner that has one; else stop."""
        if not self._alternatives:
            return self.stop(reason)
        if self._first_branch is None:
            self._first_branch = SolutionBranch([*self.branch.solutions], reason=reason)
        self._follow_alternative()
        return True

    def _follow_alternative(self) -> None:
        """Return to the last corner with another continuation, and take its first step."""
        corner = self._alternatives.pop()
        self.step_length, self._orientation = corner.length, corner.orientation
        self._exits, self._is_closed = [*corner.exits, self._at_end(corner.step)], False
        self.corrector.equations.restore(corner.state)
        self.branch.solutions[:] = corner.branch.solutions
        self.accept(corner.step, self.step_length)

    def follow_others(self) -> None:
        """Follow the other continuations of a complete branch, and keep the highest maximum.

        A corner where closed branches meet lies on all of them: a continuation that returns to it
        goes on with the next, so that a branch to the end of the window passes them all.
        """
        if self.maxima is None or not self.branch.complete:
            return
        quantity = self.maxima.quantity
        highest, best = self._highest(quantity), [*self.branch.solutions]
        limit = self._count + max(_MOST_OTHERS, len(best))
        while self._alternatives and self._count < limit:
            self.branch.complete = False
            self._follow_alternative()
            while self._count < limit and self.advance():
                pass
            if self.branch.complete and self._highest(quantity) > highest * (1 + _HIGHER):
                highest, best = self._highest(quantity), [*self.branch.solutions]
        self.branch.solutions[:] = best
        self.branch.complete, self.branch.reason = True, ""

    def _highest(self, quantity: Quantity) -> float:
        """The highest located maximum."""
        values = (quantity.value(s.x) for s in self.branch.solutions if s.located)
        return max(values, default=-np.inf)

    def finish(self, step: Step) -> bool:
        """As of ``Tracer``, with the maximum before the end of the window."""
        self.locate_maximum(step)
        return super().finish(step)

    def solve_at(self, x: Vector, p: float) -> Solution:
        """As of ``Tracer``."""
        return self.corrector.linear.newton(x, p)[0]

    def sample_end(self, solution: Solution, length: float) -> None:
        """As of ``Tracer``."""
        if self.maxima is not None:
            self.maxima.sample(self.predictor._replace(x=solution.x, p=solution.p), length)

    def stop(self, reason: str) -> bool:
        """End the branch; of several, the first one followed is kept."""
        if self._first_branch is not None:
            self.branch.solutions[:] = self._first_branch.solutions
            reason = self._first_branch.reason
        return super().stop(reason)

    def locate_maximum(self, step: Step) -> None:
        """Add the maximum within a step, if the slope falls through zero in it."""
        if self.maxima is None:
            return
        quantity, predictor = self.maxima.quantity, self.predictor
        slope = quantity.slope(predictor.x, (predictor.tangent / predictor.weights)[:-1])
        slope_after = self.corrector.observation(quantity, predictor, step).slope
        if slope <= 0 or slope_after > 0:
            return
        arc = self.corrector.arc(quantity, predictor)
        highest = self.maxima.locate(arc, slope, self.step_length)
        if highest is not None and (highest.p - self.window[1]) * self.sense < 0:
            self.branch.solutions.append(highest)
