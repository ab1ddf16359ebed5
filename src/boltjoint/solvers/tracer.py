"""Continuation of a branch step by step: the loop that every way to find a step has in common.

The step is repeated at half the length until a subclass accepts it; its length then follows the
number of corrector iterations, and the last step ends at the end of the window.
"""

from abc import ABC, abstractmethod

import numpy as np

from boltjoint.solvers.corrector import Predictor, Step
from boltjoint.solvers.equations import Solution, SolutionBranch, Vector
from boltjoint.solvers.maxima import Maxima
from boltjoint.solvers.step_control import StepControl


class Tracer(ABC):
    """Continuation of one branch, step by step; how a step is found and accepted is a subclass's.

    Parameters
    ----------
    control
        Step lengths and corrector limits.
    window
        Parameter where the branch starts and where it ends.
    branch
        To which solutions are added.
    maxima
        Location of maxima.
    """

    def __init__(
        self,
        control: StepControl,
        window: tuple[float, float],
        branch: SolutionBranch,
        maxima: Maxima | None = None,
    ) -> None:
        self.control, self.window, self.branch, self.maxima = control, window, branch, maxima
        self.step_length = min(control.first_step, control.largest_step)
        self.sense = float(np.sign(window[1] - window[0]))

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of solutions that ``StepControl.maximum_solutions`` limits."""

    @property
    @abstractmethod
    def predictor(self) -> Predictor:
        """Predictor at the last solution."""

    @abstractmethod
    def start(self, x: Vector, p: float) -> bool:
        """Solve at the start; whether it converged."""

    @abstractmethod
    def next_step(self) -> tuple[Step | None, str]:
        """The next step, at half the length until it is accepted; else the reason why none is."""

    @abstractmethod
    def accept(self, step: Step, length: float) -> None:
        """Add the solution of a step to the branch, and continue from it."""

    @abstractmethod
    def locate_maximum(self, step: Step) -> None:
        """Add the maximum within a step, if the slope falls through zero in it."""

    @abstractmethod
    def solve_at(self, x: Vector, p: float) -> Solution:
        """Solution at a fixed parameter, from an initial guess."""

    @abstractmethod
    def sample_end(self, solution: Solution, length: float) -> None:
        """Compare the solution at the end of the window, after a step, with those before it."""

    def return_from_dead_end(self, reason: str) -> bool:
        """What follows where the branch leads no further: whether it has not ended."""
        return self.stop(reason)

    def follow(self, x: Vector, p: float) -> None:
        """Follow the branch from an initial guess at a parameter until it ends."""
        if self.start(x, p):
            while self.advance():
                pass

    def advance(self) -> bool:
        """Add the next solution to the branch; whether the continuation has not ended there."""
        control = self.control
        if self.count >= control.maximum_solutions:
            return self.stop("the branch has more solutions than allowed")
        step, reason = self.next_step()
        if step is None:
            return self.return_from_dead_end(reason)
        begin, end = self.window
        if (step.solution.p - begin) * self.sense < 0:
            return self.return_from_dead_end("the branch returned to the start of the window")
        if (step.solution.p - end) * self.sense >= 0:
            return self.finish(step)
        self.locate_maximum(step)
        effort = (control.target_iterations + 1) / (step.solution.iterations + 1)
        length = self.step_length
        self.step_length = min(length * float(np.clip(effort, 0.5, 2.0)), control.largest_step)
        self.accept(step, length)
        return True

    def finish(self, step: Step) -> bool:
        """Solve exactly at the end of the window, which the last step passes."""
        last, beyond, end = self.predictor, step.solution, self.window[1]
        fraction = (end - last.p) / (beyond.p - last.p)
        solution = self.solve_at(last.x + fraction * (beyond.x - last.x), end)
        self.branch.solutions.append(solution)
        if not solution.converged:
            return self.stop("no solution found at the end of the window")
        self.sample_end(solution, fraction * self.step_length)
        self.branch.complete = True
        return False

    def stop(self, reason: str) -> bool:
        """End the branch before the end of the window."""
        self.branch.reason = reason
        return False
