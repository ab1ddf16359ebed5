"""The nonlinear mode between two successive states of a backbone, solved from an interpolation.

The mode is sought at a given amplitude. Where the backbone turns back in between, so that the
amplitude does not tell its modes apart, it is sought in the plane normal to the chord of both
states instead.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from boltjoint.dynamics.backbone.epmc import ModalState
from boltjoint.solvers.corrector import Corrector, Predictor, projection
from boltjoint.solvers.equations import Solution, Vector
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl

#: a root is found where its function is this small against the scale of the function
_ROOT = 1e-10

#: interpolations after which a root is as close as the tolerance of the equations allows
_MOST_INTERPOLATIONS = 12

#: solutions that an interval may take to shrink to rounding, half of them bisections
_MOST_SOLUTIONS = 100

#: length of the longer part of an interval that a state divides, over that of the interval
_DIVIDED = 0.9

#: of the value of a function by an interpolation that is good for something
_REDUCTION = 0.1

#: value of a function over its scale below which only the tolerance of the equations limits it
_NEAR = 1e-7

#: share of the way from a state within which an interpolation tells whether a function falls there
_ASIDE = 1e-3


@dataclass(frozen=True, eq=False)
class BetweenStates:
    """The part of a backbone between two states.

    Parameters
    ----------
    first, second
        The states.
    control
        Tolerance of the equations, and scale of the amplitude.
    """

    first: ModalState
    second: ModalState
    control: StepControl

    def interpolation(self, share: float) -> ModalState:
        """The mode by cubic Hermite interpolation; linear where the backbone turns back."""
        first, second = self.first, self.second
        a, b, t = first.unknown, second.unknown, share
        h = second.log_amplitude - first.log_amplitude
        x = a + t * (b - a)
        if not self._turns and first.slope is not None and second.slope is not None:
            at_first, at_second = h * first.slope - (b - a), h * second.slope - (b - a)
            x += t * (1 - t) * ((1 - t) * at_first - t * at_second)
        return ModalState(first.equations, x, first.log_amplitude + t * h)

    def state(self, share: float) -> ModalState | None:
        """The mode at a share of the way; None where it is not found.

        The tolerance is relative to the damping of the mode, as are errors of the response.
        """
        equations, guess = self.first.equations, self.interpolation(share)
        control = self.control.stricter(self.control.tolerance * equations.loss)
        p = guess.log_amplitude
        if not self._turns:
            nearest = newton(equations, guess.unknown, p, control, chords=True)[0]
            if nearest.converged and self._is_near(nearest, guess):
                return ModalState(equations, nearest.x, p)
        corrector = Corrector(equations, control, lambda _: control.amplitude_scale)
        chord = self._chord * self._weights
        predictor = Predictor(guess.unknown, p, self._weights, chord / np.linalg.norm(chord))
        projected = projection(corrector, predictor)
        if projected is None or not self._is_near(solution := projected[0], guess):
            return None
        return ModalState(equations, solution.x, solution.p)

    @cached_property
    def length(self) -> float:
        """Distance of the states, as that of steps along the backbone."""
        return float(np.linalg.norm(self._chord * self._weights))

    def is_divided_by(self, state: ModalState) -> bool:
        """Whether a state is nearer to both than they are to each other."""
        parts = replace(self, second=state), replace(self, first=state)
        return max(part.length for part in parts) < _DIVIDED * self.length

    @cached_property
    def _chord(self) -> Vector:
        """Change of unknown and logarithm of the amplitude."""
        first, second = self.first, self.second
        change = second.log_amplitude - first.log_amplitude
        return np.append(second.unknown - first.unknown, change)

    @cached_property
    def _weights(self) -> Vector:
        """Weights of distances, as those of the steps along the backbone."""
        weights = np.full(self._chord.size, 1 / np.linalg.norm(self.first.unknown))
        weights[-1] = 1 / self.control.amplitude_scale
        return weights

    @cached_property
    def _turns(self) -> bool:
        """Whether the amplitude does not go one way from the first state to the second.

        The tangents of both, in the sense of the chord, then differ from it in the sense of the
        amplitude; a vertical one is that of a turning point.
        """
        chord = self._chord * self._weights**2
        slopes = self.first.slope, self.second.slope
        return any(
            slope is None or (chord[:-1] @ slope + chord[-1]) * chord[-1] <= 0 for slope in slopes
        )

    def _is_near(self, solution: Solution, guess: ModalState) -> bool:
        """Whether a solution is no farther from the guess than the states from each other."""
        change = np.append(solution.x - guess.unknown, solution.p - guess.log_amplitude)
        return bool(np.linalg.norm(change * self._weights) <= self.length)


def solve_root(
    function: Callable[[ModalState], float], between: BetweenStates, scale: float
) -> ModalState:
    """The mode between two states at which a function of the mode is zero.

    Each solution is that of the equations at the root of the interpolation, and replaces the state
    on its side. Where the function bends sharply between both, as where slip begins to damp a mode
    that hardly is, an interpolation is of no use: one that does not reduce the value to a tenth is
    followed by a bisection.

    Parameters
    ----------
    function
        Function of different sign at both states.
    between
        The states.
    scale
        Size of the terms of the function.

    Returns
    -------
    ModalState
        Where the equations are not solved in between, the last one before: its value is not small.
    """
    values = function(between.first), function(between.second)
    bisects, interpolations, least, last = False, 0, np.inf, between.first
    for _ in range(_MOST_SOLUTIONS):
        share = 0.5 if bisects else _root_of_interpolation(function, between, values)
        solution = between.state(share)
        if solution is None:
            if bisects:
                break
            bisects = True
            continue
        last, value = solution, function(solution)
        far = abs(value) > max(_REDUCTION * least, _NEAR * scale)
        interpolations += not far
        if abs(value) <= _ROOT * scale or share in (0.0, 1.0):
            break
        if interpolations == _MOST_INTERPOLATIONS:
            break
        bisects, least = far and not bisects, min(least, abs(value))
        if value * values[0] > 0:
            between, values = replace(between, first=solution), (value, values[1])
        else:
            between, values = replace(between, second=solution), (values[0], value)
    return last


def solve_minimum(
    function: Callable[[ModalState], float], between: BetweenStates
) -> ModalState | None:
    """The mode between two states at which a function of the mode is least.

    Parameters
    ----------
    function
        Function of the mode.
    between
        The states.

    Returns
    -------
    ModalState
        None where the function does not fall from both states towards each other, by the tangents
        of the backbone, or the equations are not solved in between.
    """
    at_ends = function(between.first), function(between.second)
    for share, value in zip((_ASIDE, 1 - _ASIDE), at_ends, strict=True):
        if not function(between.interpolation(share)) < value:
            return None
    solutions: dict[float, ModalState | None] = {}

    def value_at(share: float) -> float:
        solutions[share] = state = between.state(share)
        return max(at_ends) if state is None else function(state)

    located = minimize_scalar(
        value_at, bounds=(0.0, 1.0), method="bounded", options={"xatol": _ASIDE}
    )
    return solutions[located.x]


def _root_of_interpolation(
    function: Callable[[ModalState], float], between: BetweenStates, values: tuple[float, float]
) -> float:
    """Share of the way at which a function of the interpolation is zero."""
    ends = {0.0: values[0], 1.0: values[1]}

    def value_at(share: float) -> float:
        return ends[share] if share in ends else function(between.interpolation(share))

    return float(brentq(value_at, 0.0, 1.0, xtol=1e-15))
