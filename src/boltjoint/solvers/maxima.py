"""Location of the local maxima of a quantity along a branch."""

from collections.abc import Callable
from typing import Any, NamedTuple

from scipy.optimize import brentq, minimize_scalar

from boltjoint.solvers.equations import Path, Quantity, Solution

#: width [of the step] within which a maximum is located
_WIDTH = 1e-6


#: deeper than any quantity lies where there is no solution, and deeper the farther away
_NOWHERE = 1e150


class Observation(NamedTuple):
    """A solution with the value of a quantity and its slope along the branch."""

    solution: Solution
    value: float
    slope: float


Arc = Callable[[float], Observation | None]
"""What is observed at an arc length from the start of a step; None where no solution is found."""


class Maxima:
    """The local maxima among the solutions of a path, located as the path grows.

    A sampled solution that is no lower than its neighbours, and higher than any maximum located
    between them, is evidence of one that was not found: it is sought around that solution. If
    nothing higher is found there, the solution itself is the maximum.

    Parameters
    ----------
    path
        To which located maxima are added.
    quantity
        What is observed.
    arc_from
        The branch by arc length, from what ``sample`` was given for one solution towards the next.
    """

    def __init__(self, path: Path, quantity: Quantity, arc_from: Callable[[Any, Any], Arc]) -> None:
        self.path, self.quantity, self._arc_from = path, quantity, arc_from
        self._samples: list[_Sample] = []

    def locate(self, arc: Arc, slope: float, reach: float) -> Solution | None:
        """The maximum within a step at whose start the slope is above zero."""
        highest = by_slope(arc, slope, reach) or by_value(arc, reach)
        return highest and highest.solution._replace(located=True)

    def sample(self, origin: Any, reach: float) -> None:  # noqa: ANN401 - of the tracer
        """Note the last solution of the path, which a step of length ``reach`` led to."""
        index = len(self.path.solutions) - 1
        last = _Sample(index, self._value(index), origin, reach)
        self._samples = [*(each for each in self._samples if each.index < index), last][-3:]
        if len(self._samples) == 3:
            self._refine(*self._samples)

    def _refine(self, first: "_Sample", middle: "_Sample", last: "_Sample") -> None:
        """Seek the maximum that three samples in a row are evidence of, if it is not located."""
        if middle.value < max(first.value, last.value) or first.value == middle.value == last.value:
            return
        between = range(first.index + 1, last.index)
        if any(self.path.solutions[i].located and self._value(i) >= middle.value for i in between):
            return
        steps = [
            (self._arc_from(begin.origin, end.origin), end)
            for begin, end in ((first, middle), (middle, last))
        ]
        highest, at = None, middle.index
        for arc, end in steps:
            found = _highest(arc, end.reach)
            if found is not None and (highest is None or found.value > highest.value):
                highest, at = found, end.index
        for arc, end in steps:
            # a sample of a lagging basis lies beside the branch: put it on
            if highest is None or highest.value < self._value(end.index):
                found = arc(end.reach)
                if found is not None:
                    self.path.solutions[end.index] = found.solution
        if highest is None or highest.value < self._value(middle.index):
            solution = self.path.solutions[middle.index]
            self.path.solutions[middle.index] = solution._replace(located=True)
            return
        self.path.solutions.insert(at, highest.solution._replace(located=True))
        self._samples = [
            each._replace(index=each.index + (each.index >= at)) for each in self._samples
        ]

    def _value(self, index: int) -> float:
        return self.quantity.value(self.path.solutions[index].x)


class _Sample(NamedTuple):
    index: int
    value: float
    origin: Any
    reach: float


def _highest(arc: Arc, reach: float) -> Observation | None:
    """The highest solution of a step: where the slope falls through zero, or wherever it is."""
    start = arc(_WIDTH * reach)
    found = by_slope(arc, start.slope, reach) if start is not None and start.slope > 0 else None
    return found or by_value(arc, reach)


def by_slope(arc: Arc, slope: float, reach: float) -> Observation | None:
    """The maximum at which the slope falls through zero.

    Parameters
    ----------
    arc
        The step.
    slope, reach
        Slope at its start, above zero, and its length.

    Returns
    -------
    Observation or None
        None where the slope is still above zero at the end, or a solution is not found.
    """
    tried: dict[float, Observation] = {}

    def slope_at(length: float) -> float:
        if length == 0:
            return slope
        observed = arc(length)
        if observed is None:
            raise _Lost
        tried[length] = observed
        return observed.slope

    try:
        return tried.get(brentq(slope_at, 0.0, reach, xtol=_WIDTH * reach, rtol=1e-9))
    except (_Lost, ValueError):
        return None


def by_value(arc: Arc, reach: float) -> Observation | None:
    """The highest solution of a step, however its slope behaves.

    Beyond a corner of the branch there may be none on the spheres around the start of the step.

    Parameters
    ----------
    arc, reach
        The step and its length.
    """
    highest: Observation | None = None

    def depth(length: float) -> float:
        nonlocal highest
        observed = arc(length)
        if observed is None:
            return _NOWHERE * (1 + length / reach)
        if highest is None or observed.value > highest.value:
            highest = observed
        return -observed.value

    options = {"xatol": _WIDTH * reach}
    minimize_scalar(depth, bounds=(0.0, reach), method="bounded", options=options)
    return highest


class _Lost(Exception):
    """A solution was not found while a maximum was being located."""
