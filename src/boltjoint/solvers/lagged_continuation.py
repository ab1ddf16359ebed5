"""Arc-length continuation in a basis that depends on the response, with step-length control.

Equations in a held basis may have a turning point, or no solution ahead, where the full equations
have none. Where the basis is implicit, its solutions are those of the full equations, and the
branch is continued in these until a step in the basis converges again.
"""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from boltjoint.solvers.arc_length import CornerTracer
from boltjoint.solvers.corrector import Corrector, Predictor, Step, projection
from boltjoint.solvers.equations import (
    Quantity,
    Solution,
    SolutionBranch,
    StepControl,
    Vector,
)
from boltjoint.solvers.lagged_basis import LaggedCorrector, LaggedEquations, Origin
from boltjoint.solvers.maxima import Maxima, highest_of_step
from boltjoint.solvers.tracer import Tracer


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
    branch, maxima = SolutionBranch(), None
    if maximise is not None:
        arc = partial(corrector.arc_between, maximise)
        maxima = Maxima(branch, maximise, arc, control.peak_tolerance, corrector.exact)
    tracer = LaggedTracer(corrector, window, branch, maxima)
    tracer.follow(start, window[0] if begin is None else begin)
    if corrector.full is not None and maximise is not None:
        _polish_maxima(branch, maximise, corrector)
    return branch


class LaggedTracer(Tracer):
    """Continuation in a basis that depends on the response; where it fails, in the full equations.

    Parameters
    ----------
    corrector
        Corrector in the basis.
    window, branch
        As for ``Tracer``.
    maxima
        Location of maxima, whose origins are those of the corrector.
    """

    def __init__(
        self,
        corrector: LaggedCorrector,
        window: tuple[float, float],
        branch: SolutionBranch,
        maxima: Maxima | None = None,
    ) -> None:
        super().__init__(corrector.control, window, branch, maxima)
        self.corrector = corrector
        self.full_steps = self.control.lagged.full_steps
        self.secant: Vector | None = None
        #: from the farthest solution back to the last one
        self.backtracking_distance = 0.0
        #: of all steps in the full equations, so that it knows the corners that were passed
        self._full_tracer: CornerTracer | None = None

    @property
    def count(self) -> int:
        """Number of solutions, located maxima among them."""
        return len(self.branch.solutions)

    @property
    def predictor(self) -> Predictor:
        """Predictor at the last solution, in the present basis."""
        return self.corrector.predictor

    def start(self, x: Vector, p: float) -> bool:
        """Solve at the start in a basis of the solution itself; whether it converged."""
        first = self.corrector.start(x, p, self.sense)
        self.branch.solutions.append(first)
        self._sample(0.0)
        return first.converged or self.stop("no solution found at the start of the window")

    def next_step(self) -> tuple[Step | None, str]:
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

    def without_step(self, reason: str) -> bool:
        """Continue in the full equations where there are any; else stop."""
        full = self.corrector.full
        return self.stop(reason) if full is None else self._follow_full_equations(full)

    def locate_maximum(self, step: Step) -> None:
        """As of ``Tracer``; a predictive basis moves within the step."""
        if self.maxima is None or self.corrector.equations.predictive:
            return
        highest = self.corrector.locate_maximum(self.maxima, step, self.step_length)
        self.branch.solutions += [highest] if highest is not None else []

    def accept(self, step: Step, length: float) -> None:
        """Add the solution of a step to the branch, and update the basis for the next."""
        secant = self.corrector.secant(step)
        self.backtracking_distance = self._backtracking(secant)
        self.secant = secant if self.backtracking_distance == 0 else self.secant
        origin = self.corrector.origin_of(step)
        self.branch.solutions.append(step.solution._replace(x=origin.q, reduced=True))
        self.corrector.advance(origin, self.step_length / length)
        self._sample(length)
        self.full_steps = max(self.control.lagged.full_steps, self.full_steps // 2)

    def _follow_full_equations(self, full: Corrector) -> bool:
        """Take steps in the full equations; whether the continuation has not ended in these."""
        origin = self.corrector.origin
        predictor = full.predictor_at(*origin)
        projected = projection(full, predictor)
        if projected is None:
            return self.stop("no solution found near the last one")
        if self._full_tracer is None:
            self._full_tracer = CornerTracer(full, self.window, self.branch, self.maxima)
        tracer = self._full_tracer
        tracer.enter(Step(*projected, origin.direction), self.step_length)
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

    def solve_at(self, x: Vector, p: float) -> Solution:
        """As of ``Tracer``, in the present basis."""
        return self.corrector.solution_at(x, p)

    def sample_end(self, solution: Solution, length: float) -> None:
        """As of ``Tracer``."""
        self.corrector.origin = self.corrector.origin._replace(q=solution.x, p=solution.p)
        self._sample(length)

    def _sample(self, length: float) -> None:
        if self.maxima is not None:
            self.maxima.sample(self.corrector.origin, length)


def _polish_maxima(branch: SolutionBranch, quantity: Quantity, corrector: LaggedCorrector) -> None:
    """Solve the full equations wherever a solution in the basis is higher than both neighbours.

    Beside those corrected as the branch was followed the error of others makes them higher, one
    after another. One that is no solution of the full equations, where the basis led beyond a turn
    of these, is left out. What is still higher than both neighbours then is a maximum.
    """
    solutions = branch.solutions
    tried = [not solution.reduced for solution in solutions]
    while True:
        values = [quantity.value(solution.x) for solution in solutions]
        highs = [
            i for i in range(1, len(values) - 1) if values[i] >= max(values[i - 1], values[i + 1])
        ]
        near = sorted({i + step for i in highs for step in (-1, 0, 1) if not tried[i + step]})
        for i in near:
            tried[i] = True
            first, solution, last = solutions[max(i - 1, 0)], solutions[i], solutions[i : i + 2][-1]
            direction = np.append(last.x - first.x, last.p - first.p)
            exact = corrector.exact_near(solution.x, solution.p, direction)
            if exact is not None:
                solutions[i] = exact[0]._replace(iterations=solution.iterations)
        wrong = [i for i in highs if solutions[i].reduced]
        for i in reversed(wrong):
            del solutions[i], tried[i]
        if not near and not wrong:
            break
    # a maximum beside solutions that are now higher was one of their errors
    for i, solution in enumerate(solutions):
        if i not in highs:
            solutions[i] = solution._replace(located=False)
        elif not solution.located:
            highest = _located_around(solutions[i - 1 : i + 2], quantity, corrector)
            solutions[i] = highest._replace(located=True, iterations=solution.iterations)


def _located_around(
    solutions: Sequence[Solution], quantity: Quantity, corrector: LaggedCorrector
) -> Solution:
    """The highest solution of the full equations around the middle one of three, or that itself."""
    full, found = corrector.full, solutions[1]
    assert full is not None  # or nothing was polished
    for begin, end in pairwise(solutions):
        towards = Origin(end.x, end.p, np.append(end.x - begin.x, end.p - begin.p))
        predictor = full.predictor_at(begin.x, begin.p, towards.direction)
        arc = corrector.arc_between(quantity, predictor, towards, 1.0)
        highest = highest_of_step(arc, 1.0, corrector.control.peak_tolerance)
        if highest is not None and highest.value > quantity.value(found.x):
            found = highest.solution
    return found
