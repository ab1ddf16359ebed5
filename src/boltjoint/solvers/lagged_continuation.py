"""Arc-length continuation in a basis that depends on the response, with step-length control.

Equations in a held basis may have a turning point, or no solution ahead, where the full equations
have none: a branch that is to be one of these takes its steps in the basis as predictions
(``arc_length``).
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from boltjoint.solvers.corrector import Predictor, Step
from boltjoint.solvers.equations import Quantity, Solution, SolutionBranch, Vector
from boltjoint.solvers.lagged_basis import LaggedCorrector, LaggedEquations
from boltjoint.solvers.maxima import Maxima
from boltjoint.solvers.step_control import StepControl
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
        maxima = Maxima(branch, maximise, arc, control.peak_tolerance)
    tracer = LaggedTracer(corrector, window, branch, maxima)
    tracer.follow(start, window[0] if begin is None else begin)
    return branch


class LaggedTracer(Tracer):
    """Continuation in a basis that depends on the response.

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
        self.secant: Vector | None = None
        #: from the farthest solution back to the last one
        self.backtracking_distance = 0.0

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
        while self.step_length >= self.control.smallest_step:
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
