"""Event location: local maxima of a quantity along a solution branch."""

from collections.abc import Callable
from typing import Any, NamedTuple

from scipy.optimize import brentq, minimize_scalar

from boltjoint.solvers.equations import Quantity, Solution, SolutionBranch

#: minimised in place of the negative value where there is no solution; it grows with the distance
_NO_VALUE = 1e150


class Observation(NamedTuple):
    """A solution with the value of a quantity and its slope along the branch."""

    solution: Solution
    value: float
    slope: float


Arc = Callable[[float], Observation | None]
"""Observation at a distance from the start of a step; None where no solution is found."""


class Maxima:
    """Location of the local maxima of a quantity while a branch is followed.

    Around a solution that is no lower than its neighbours, and higher than any maximum located
    between them, a maximum is sought that the slope did not show. If nothing higher is found there,
    the solution itself is the maximum.

    Parameters
    ----------
    branch
        To which located maxima are added.
    quantity
        The quantity.
    arc_between
        The branch by the distance from one solution towards the next, each given by the origin
        passed to ``sample``.
    tolerance
        Tolerance of the location, relative to the step length.
    """

    def __init__(
        self,
        branch: SolutionBranch,
        quantity: Quantity,
        arc_between: Callable[[Any, Any], Arc],
        tolerance: float,
    ) -> None:
        self.tolerance = tolerance
        self.branch, self.quantity, self._arc_between = branch, quantity, arc_between
        self._samples: list[_Sample] = []

    def locate(self, arc: Arc, slope: float, length: float) -> Solution | None:
        """The maximum within a step at whose start the slope is positive."""
        width = self.tolerance * length
        highest = _by_slope(arc, slope, length, width) or _by_value(arc, length, width)
        return highest and highest.solution._replace(located=True)

    def sample(self, origin: Any, length: float) -> None:  # noqa: ANN401 - of the tracer
        """Compare the last solution of the branch, at the end of a step, with those before it."""
        solutions = self.branch.solutions
        index = len(solutions) - 1
        # a branch that returned to a corner has others after it, and some of those before
        before = [
            each
            for each in self._samples
            if each.place < index and solutions[each.place] is each.solution
        ]
        self._samples = [*before, _Sample(index, solutions[index], origin, length)][-3:]
        if len(self._samples) == 3:
            self._refine(*self._samples)

    def _refine(self, first: "_Sample", middle: "_Sample", last: "_Sample") -> None:
        """Locate a maximum between three successive solutions of which the middle is highest."""
        values = [self._value(sample.solution) for sample in (first, middle, last)]
        if not values[1] >= max(values) or min(values) == max(values):
            return
        solutions = self.branch.solutions
        between = solutions[first.place + 1 : last.place]
        if any(solution.located and self._value(solution) >= values[1] for solution in between):
            return
        steps = [
            (self._arc_between(begin.origin, end.origin), end)
            for begin, end in ((first, middle), (middle, last))
        ]
        highest, at = None, middle.place
        for arc, end in steps:
            located = _highest_of_step(arc, end.length, self.tolerance * end.length)
            if located is not None and (highest is None or located.value > highest.value):
                highest, at = located, end.place
        for arc, end in steps:
            # a solution higher than the maximum beside it is less accurate: correct it
            if highest is None or highest.value < self._value(end.solution):
                corrected = arc(end.length)
                if corrected is not None:
                    self._put(end, corrected.solution)
        if highest is None or highest.value < self._value(solutions[middle.place]):
            self._put(middle, solutions[middle.place]._replace(located=True))
            return
        solutions.insert(at, highest.solution._replace(located=True))
        self._samples = [
            sample._replace(place=sample.place + (sample.place >= at)) for sample in self._samples
        ]

    def _put(self, sample: "_Sample", solution: Solution) -> None:
        """Put another solution in place of a sample's."""
        self.branch.solutions[sample.place] = solution
        self._samples = [
            other._replace(solution=solution) if other.place == sample.place else other
            for other in self._samples
        ]

    def _value(self, solution: Solution) -> float:
        return self.quantity.value(solution.x)


class _Sample(NamedTuple):
    """A solution and its place on the branch, and the length of the step that ends there."""

    place: int
    solution: Solution
    origin: Any
    length: float


def _highest_of_step(arc: Arc, length: float, width: float) -> Observation | None:
    """The highest solution of a step: at a zero of the slope, or by value alone."""
    start, highest = arc(width), None
    if start is not None and start.slope > 0:
        highest = _by_slope(arc, start.slope, length, width)
    return highest or _by_value(arc, length, width)


def _by_slope(arc: Arc, slope: float, length: float, width: float) -> Observation | None:
    """The zero of a slope that is positive at the start of a step.

    None where the slope is still positive at the end, or a solution is not found.
    """
    observations: dict[float, Observation] = {}

    def slope_at(distance: float) -> float:
        if distance == 0:
            return slope
        observation = arc(distance)
        if observation is None:
            raise ValueError("no solution")
        observations[distance] = observation
        return observation.slope

    try:
        zero = brentq(slope_at, 0.0, length, xtol=width, rtol=1e-9)
        return observations.get(zero)
    except ValueError:
        return None


def _by_value(arc: Arc, length: float, width: float) -> Observation | None:
    """The highest solution of a step, whatever its slope.

    Beyond a corner of the branch there may be none on the spheres around the start of the step.
    """
    highest: Observation | None = None

    def negative_value(distance: float) -> float:
        nonlocal highest
        observation = arc(distance)
        if observation is None:
            return _NO_VALUE * (1 + distance / length)
        if highest is None or observation.value > highest.value:
            highest = observation
        return -observation.value

    options = {"xatol": width}
    minimize_scalar(negative_value, bounds=(0.0, length), method="bounded", options=options)
    return highest
