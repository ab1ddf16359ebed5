"""Arc-length continuation in a basis that depends on the response, with step-length control.

Equations in a held basis may have a turning point, or no solution ahead, where the full equations
have none. Where the basis is implicit, its solutions are those of the full equations, and the
branch is continued in these until a step in the basis converges again.
"""

from collections.abc import Callable

import numpy as np

from boltjoint.solvers.arc_length import Tracer
from boltjoint.solvers.corrector import Step, projection
from boltjoint.solvers.equations import Equations, Quantity, SolutionBranch, StepControl, Vector
from boltjoint.solvers.lagged_basis import LaggedCorrector, LaggedEquations, Origin
from boltjoint.solvers.maxima import Maxima
from boltjoint.solvers.newton import newton


def trace(
    equations: LaggedEquations,
    start: Vector,
    window: tuple[float, float],
    control: StepControl,
    *,
    scale: float | Callable[[float], float],
    maximise: Quantity | None = None,
    begin: float | None = None,
) -> SolutionBranch:
    """Follow a solution branch from one end of a parameter window to the other.

    Parameters
    ----------
    equations
        The system in its basis.
    start
        Initial guess of the response in fixed coordinates.
    window, control, scale, maximise, begin
        As for ``arc_length.trace``; the quantity is a function of the fixed coordinates.

    Returns
    -------
    SolutionBranch
        In fixed coordinates.
    """
    scale_at = scale if callable(scale) else lambda _: scale
    corrector = LaggedCorrector(equations, control, scale_at)
    branch = _LaggedTracer(corrector, window, maximise).run(
        start, window[0] if begin is None else begin
    )
    if corrector.full is not None and maximise is not None:
        _polish_maxima(branch, maximise, equations.full_equations, control)
    return branch


class _LaggedTracer:
    """Continuation of one branch."""

    def __init__(
        self, corrector: LaggedCorrector, window: tuple[float, float], maximise: Quantity | None
    ) -> None:
        self.corrector, self.control, self.window = corrector, corrector.control, window
        self.branch, self.maxima = SolutionBranch(), None
        if maximise is not None:
            self.maxima = Maxima(
                self.branch,
                maximise,
                lambda *ends: corrector.arc_between(maximise, *ends),
                self.control.peak_tolerance,
            )
        self.sense = float(np.sign(window[1] - window[0]))
        self.step_length = min(self.control.first_step, self.control.largest_step)
        self.full_steps = self.control.lagged.full_steps
        self.secant: Vector | None = None
        #: from the farthest solution back to the last one
        self.backtracking_distance = 0.0

    def run(self, start: Vector, p: float) -> SolutionBranch:
        """The branch from an initial guess at a parameter."""
        first = self.corrector.start(start, p, self.sense)
        self.branch.solutions.append(first)
        self._sample(0.0)
        if not first.converged:
            return self._stop("no solution found at the start of the window")
        while len(self.branch.solutions) < self.control.maximum_solutions:
            step, reason = self._next()
            if step is None:
                if self.corrector.full is None:
                    return self._stop(reason)
                if not self._follow_full_equations():
                    return self.branch
            elif (step.solution.p - self.window[0]) * self.sense < 0:
                return self._stop("the branch returned to the start of the window")
            elif (step.solution.p - self.window[1]) * self.sense >= 0:
                return self._finish(step)
            else:
                self._accept(step)
        return self._stop("the branch has more solutions than allowed")

    def _next(self) -> tuple[Step | None, str]:
        """The next step, halved until it is accepted; else the reason why none is."""
        corrector, projected, reason = self.corrector, False, ""
        lagged = self.control.lagged
        shortest = self.control.smallest_step
        if corrector.full is not None:
            shortest = max(lagged.shortest_step, self.step_length / lagged.largest_reduction)
        while self.step_length >= shortest:
            step = corrector.correct(self.step_length)
            if step is not None:
                secant = corrector.secant(step)
                continuous = np.linalg.norm(secant) <= lagged.longest_secant
                if continuous and self._backtracking(secant) <= lagged.backtracking_distance:
                    return step, ""
                reason = "the branch would jump or turn back"
            else:
                reason = "no solution found near the last one"
                if not (corrector.equations.predictive or projected):
                    corrector.project()
                    projected = True
                    continue
            self.step_length *= 0.5
            corrector.halve()
        return None, reason

    def _backtracking(self, secant: Vector) -> float:
        """Backtracking distance after a step: a basis update may reverse the direction."""
        if self.secant is None:
            return 0.0
        progress = float(secant @ self.secant) / float(np.linalg.norm(self.secant))
        return max(0.0, self.backtracking_distance - progress)

    def _accept(self, step: Step) -> None:
        """Add the solution of a step to the branch, and update the basis for the next."""
        control, solution = self.control, step.solution
        secant = self.corrector.secant(step)
        self.backtracking_distance = self._backtracking(secant)
        self.secant = secant if self.backtracking_distance == 0 else self.secant
        if self.maxima is not None and not self.corrector.equations.predictive:
            highest = self.corrector.locate_maximum(self.maxima, step, self.step_length)
            self.branch.solutions += [highest] if highest is not None else []
        effort = (control.target_iterations + 1) / (solution.iterations + 1)
        length = self.step_length
        self.step_length = min(length * float(np.clip(effort, 0.5, 2.0)), control.largest_step)
        origin = self.corrector.origin_of(step)
        self.branch.solutions.append(solution._replace(x=origin.q, reduced=True))
        self.corrector.advance(origin, self.step_length / length)
        self._sample(length)
        self.full_steps = max(control.lagged.full_steps, self.full_steps // 2)

    def _follow_full_equations(self) -> bool:
        """Take steps in the full equations; whether the continuation has not ended in these."""
        full, origin = self.corrector.full, self.corrector.origin
        _, jacobian_at = full.equations.evaluate(origin.q, origin.p)
        predictor = full.predictor(origin.q, origin.p, jacobian_at(), origin.direction)
        projected = projection(full, predictor)
        if projected is None:
            self._stop("no solution found near the last one")
            return False
        tracer = Tracer(full, self.window, self.branch, self.maxima)
        tracer.step_length = self.step_length
        tracer.resume(Step(*projected, origin.direction))
        for _ in range(self.full_steps):
            before = tracer.predictor
            if not tracer.advance():
                return False
        self.full_steps *= 2
        shortest = 2 * self.control.lagged.shortest_step
        last, self.step_length = tracer.predictor, max(tracer.step_length, shortest)
        direction = np.append(last.x - before.x, last.p - before.p)
        self.corrector.origin = Origin(before.x, before.p, direction)
        self.corrector.advance(Origin(last.x, last.p, direction), 1.0)
        self.secant, self.backtracking_distance = None, 0.0
        return True

    def _finish(self, step: Step) -> SolutionBranch:
        """Solve exactly at the end of the window, which the last step passes."""
        last, beyond, end = self.corrector.predictor, step.solution, self.window[1]
        fraction = (end - last.p) / (beyond.p - last.p)
        guess = last.x + fraction * (beyond.x - last.x)
        solution = self.corrector.solution_at(guess, end)
        self.branch.solutions.append(solution)
        if not solution.converged:
            return self._stop("no solution found at the end of the window")
        self.corrector.origin = self.corrector.origin._replace(q=solution.x, p=end)
        self._sample(fraction * self.step_length)
        self.branch.complete = True
        return self.branch

    def _stop(self, reason: str) -> SolutionBranch:
        self.branch.reason = reason
        return self.branch

    def _sample(self, length: float) -> None:
        if self.maxima is not None:
            self.maxima.sample(self.corrector.origin, length)


def _polish_maxima(
    branch: SolutionBranch, quantity: Quantity, equations: Equations, control: StepControl
) -> None:
    """Solve the full equations at the solutions around each maximum in a lagged basis.

    The error of a solution must not make it higher than the maximum located beside it. What is
    still higher than both neighbours then is a maximum.
    """
    solutions, polished = branch.solutions, set()
    while True:
        values = [quantity.value(solution.x) for solution in solutions]
        highs = [
            i for i in range(1, len(values) - 1) if values[i] >= max(values[i - 1], values[i + 1])
        ]
        near = {i + step for i in highs for step in (-1, 0, 1)} - polished
        if not near:
            break
        polished |= near
        for i in near:
            solution = solutions[i]
            if solution.located or not solution.reduced:
                continue
            corrected, _ = newton(equations, solution.x, solution.p, control)
            change = np.linalg.norm(corrected.x - solution.x)
            limit = control.lagged.largest_correction * np.linalg.norm(solution.x)
            if corrected.converged and change <= limit:
                solutions[i] = corrected._replace(iterations=solution.iterations)
    for i in highs:
        solutions[i] = solutions[i]._replace(located=True)
