"""Continuation of a frequency response across its window.

A branch starts from the stuck linear solution at one end of the window, or from a solution found by
load stepping (homotopy in the force); one that does not cross the window is started elsewhere.
"""

from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance, OutputPoint
from boltjoint.solvers import arc_length, lagged_continuation
from boltjoint.solvers.arc_length import Prediction
from boltjoint.solvers.compiled_arc_length import follow
from boltjoint.solvers.compiled_steps import Limits
from boltjoint.solvers.equations import Equations, LazyJacobian, SolutionBranch
from boltjoint.solvers.lagged_basis import BasisPrediction, LaggedEquations
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl

#: where in the window a branch is started that does not cross it from its ends
_STARTS_INSIDE = (0.5, 0.25, 0.75)

#: factor by which steps are shorter where a branch crosses the window from none of its starts
_SHORTER_STEPS = 4.0

#: residual on the way to a peak, over the force: peaks of 140 designs were the same within 2e-11
_TOLERANCE_TO_PEAK = 1e-3
#: part of its peak to which a response has fallen where nothing higher is behind
_FALLS_TO = 0.9

#: load factors at which load stepping begins, until little slips and the corrector converges
_LOAD_FACTORS = (1e-3, 1e-6, 1e-9)


class LoadStepping(Equations):
    """Equations at a fixed frequency whose parameter is the logarithm of the load factor.

    Parameters
    ----------
    equations
        In linear modes or self-consistent RDNM, followed while their excitation grows.
    w
        The frequency [rad/s].
    """

    def __init__(self, equations: BalanceEquations, w: float) -> None:
        self._equations, self._w = equations, w
        self.residual_scale = equations.residual_scale

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and Jacobian under exp(p) times the excitation."""
        return self._equations.evaluate(x, self._w, np.exp(p))

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the logarithm of the load factor."""
        return np.exp(p) * self._equations.load_factor_derivative(x)

    def accept(self, x: NDArray[np.float64]) -> None:
        """As of the equations."""
        self._equations.accept(x)

    def state(self) -> object:
        """As of the equations."""
        return self._equations.state()

    def restore(self, state: object) -> None:
        """As of the equations."""
        self._equations.restore(state)


class Continuation:
    """Continuation of the response to one force across a frequency window, with its starts.

    Parameters
    ----------
    equations, balance
        In their coordinates, and the modal equations they stand for.
    control
        Tolerance and step lengths.
    output
        The point whose amplitude is maximised.
    window
        Frequencies [Hz] that set the scale of steps.
    repeats
        Whether a branch that breaks off is followed again from other starts and with shorter steps.
    """

    def __init__(
        self,
        equations: BalanceEquations,
        balance: HarmonicBalance,
        control: StepControl,
        output: OutputPoint,
        window: tuple[float, float],
        repeats: bool = True,
    ) -> None:
        self._equations, self._balance, self._control = equations, balance, control
        self._output, self._repeats = output, repeats
        self._largest_scale = control.window_scale * 2 * np.pi * (window[1] - window[0])
        self._prediction: Prediction | None = None
        #: the equations themselves or, in a basis, those in fixed coordinates that it predicts
        self._full: BalanceEquations | None = equations
        if isinstance(equations, LaggedEquations):
            full = equations.full_equations
            self._full = full if isinstance(full, BalanceEquations) else None
            if self._full is not None:
                self._prediction = BasisPrediction(equations, control, self._scale)

    def across(
        self, window: tuple[float, float], start: NDArray[np.float64] | None
    ) -> SolutionBranch:
        """Branch from one end of a window [rad/s] to the other, with shorter steps if need be.

        One that is not led across by predictions in a basis is followed without them.
        """
        if self._prediction is not None and self._full is not None:
            branch = self._follow(window, window[0], start)
            if branch.complete:
                return branch
            full = copy(self)
            full._equations, full._prediction = self._full, None
            other = full.across(window, start)
            return other if other.complete else branch
        regular = self._follow_compiled(window, start, self._control)
        if regular is not None:
            return regular
        branch = self._from_starts(window, start)
        if branch.complete or not self._repeats:
            return branch
        steps, self._control = self._control, self._control.with_shorter_steps(_SHORTER_STEPS)
        other = self._from_starts(window, start)
        self._control = steps
        return other if other.complete else branch

    def _from_starts(
        self, window: tuple[float, float], start: NDArray[np.float64] | None
    ) -> SolutionBranch:
        """Branch from the lower end of a window, or from other starts if incomplete."""
        low, high = window
        branch = self._follow((low, high), low, start)
        if branch.complete or start is not None or not self._repeats:
            return branch
        for begin in (high, *(low + part * (high - low) for part in _STARTS_INSIDE)):
            other = self._through(window, begin)
            if other.complete:
                return other
        return branch

    def _through(self, window: tuple[float, float], begin: float) -> SolutionBranch:
        """Branch from a frequency in the window to both of its ends."""
        low, high = window
        start = self._start(begin)
        down = self._follow((high, low), begin, start)
        if not down.complete:
            return down
        if begin == high:
            return SolutionBranch(down.solutions[::-1], complete=True)
        up = self._follow((low, high), begin, start)
        return SolutionBranch(down.solutions[:0:-1] + up.solutions, up.complete, up.reason)

    def _follow(
        self, window: tuple[float, float], begin: float, start: NDArray[np.float64] | None
    ) -> SolutionBranch:
        if start is None:
            start = self._start(begin)
        if self._full is not None:
            trace = partial(arc_length.trace, self._full, prediction=self._prediction)
        else:
            lagged = checks.instance("equations", self._equations, LaggedEquations)
            trace = partial(lagged_continuation.trace, lagged)
        return trace(
            start,
            window,
            self._control,
            scale=self._scale,
            maximise=self._output,
            begin=begin,
        )

    def to_peak(self, window: tuple[float, float]) -> SolutionBranch | None:
        """Branch from the lower end of a window [rad/s] to a little behind its peak.

        Only the peak is within the tolerance. None where the branch has no such course, or no peak.
        """
        rough = replace(self._control, tolerance=max(self._control.tolerance, _TOLERANCE_TO_PEAK))
        branch = self._follow_compiled(window, None, rough, _FALLS_TO)
        has_peak = branch is not None and any(each.located for each in branch.solutions)
        return branch if has_peak else None

    def _follow_compiled(
        self,
        window: tuple[float, float],
        start: NDArray[np.float64] | None,
        control: StepControl,
        falls_to: float = 0.0,
    ) -> SolutionBranch | None:
        """The branch where it takes its regular course, and has a compiled system."""
        system = self._equations.compiled_system()
        if system is None:
            return None
        limits, at_peak = (
            Limits.of(
                each,
                self._equations.residual_scale,
                self._largest_scale,
                each.parameter_scale,
            )
            for each in (control, self._control)
        )
        guess = self._balance.stuck_solution(window[0]) if start is None else start
        path = follow(system, guess, window, limits, at_peak, falls_to)
        if path.size == 0 and start is None:
            path = follow(system, self._start(window[0]), window, limits, at_peak, falls_to)
        return path.branch() if path.complete else None

    def _scale(self, w: float) -> float:
        return min(self._largest_scale, self._control.parameter_scale * w)

    def _start(self, w: float) -> NDArray[np.float64]:
        """An initial guess: the stuck linear solution, or the end of load stepping from it."""
        stuck = self._balance.stuck_solution(w)
        if self._full is None:
            return stuck  # a lagged basis is no use far from its solution
        if newton(self._full, stuck, w, self._control)[0].converged:
            return stuck
        loading = LoadStepping(self._full, w)
        for factor in _LOAD_FACTORS:
            window = np.log(factor), 0.0
            branch = arc_length.trace(loading, factor * stuck, window, self._control, scale=1.0)
            if branch.complete:
                return branch.solutions[-1].x
        return stuck
