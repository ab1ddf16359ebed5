"""Where do the solutions of r(x, p) = 0 lie as a parameter p moves through a window?

Newton's method and arc-length continuation for any system of equations. A path is followed on
spheres around its last solution (eq. 2.39 to 2.42 of the source study), so it passes turning
points. Distances are measured relative to the size of the last solution, because a resonance spans
orders of magnitude: ``|dx|^2 / |x|^2 + (dp / scale)^2``.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Vector = NDArray[np.float64]

Event = Callable[[Vector, Vector], float]
"""A function of the unknown and of its derivative along the path."""


class Equations(Protocol):
    """A system of equations with one parameter, whose unknown may be re-expressed on the way."""

    residual_scale: float
    """What a residual is compared to."""

    basis: object
    """What the unknown presently means; ``renew`` changes it, and it may be set back."""

    def evaluate(self, x: Vector, p: float) -> tuple[Vector, Callable[[], NDArray[np.float64]]]:
        """Residual, and what forms its derivative by x, which not every solution needs."""

    def parameter_derivative(self, x: Vector, p: float) -> Vector:
        """Derivative of the residual by p."""

    looks_ahead: bool
    """Whether a renewal makes use of where the path is expected to go."""

    repeats_steps: bool
    """Whether a step is made anew, in renewed terms, until it leads to where it was expected to."""

    def renew(
        self, x: Vector, p: float, along: Vector, ahead: tuple[Vector, float]
    ) -> tuple[Vector, Vector] | None:
        """Change what the unknown means once x is accepted: x and a direction, re-expressed.

        ``ahead`` is the fixed form of the unknown, and the parameter, that are expected next. None
        where the meaning stays.
        """

    def to_fixed(self, x: Vector) -> Vector:
        """Express x in terms that no renewal changes, as paths record it."""


#: renewals after which a path begins, settled or not
_MOST_RENEWALS = 100

#: relative change of a renewed unknown that no longer matters to where a path starts
_SETTLED = 1e-6


#: a residual this small against the terms it is the sum of is their rounding
_ROUNDING = 4 * np.finfo(float).eps

#: a longer way [arc length] between two solutions is a jump to elsewhere
_JUMP = 0.2

#: so far back [arc length] a renewed unknown may waver without turning back
_WAVER = 0.02

#: arc within which a path may turn by more than a right angle: a corner of the law, not a step
#: too long to see the curve
_CORNER = 1e-3

#: times that a step is made anew, or an event located anew, in renewed terms
_LOOKS = 8

#: least and largest part of the way from what was expected to what was found
_SHARES = 0.05, 1.0

#: change of an unknown, over the step, between what a renewal expected and what is found
_AGREED = 0.05

#: arc within which an event is known well enough where a renewal moves it
_EVENT_ARC = 1e-3

#: an unknown this small against the largest on the path counts as zero, whose relative change is
#: without meaning
_SMALL = 1e-3


@dataclass(frozen=True)
class StepControl:
    """How long the steps are and how hard the corrector tries.

    Parameters
    ----------
    tolerance
        A residual below this times its scale is zero, and so is one that its terms' rounding hides.
    first_step, smallest_step, largest_step
        Arc lengths; the first step is no longer than the largest.
    target_iterations
        Corrector effort at which the step stays as it is; below it grows, above it shrinks.
    most_iterations
        After so many corrections a step is given up and retried at half the length.
    most_solutions
        A path longer than this is given up.

    Raises
    ------
    ValueError
        If one of them is not positive.
    """

    tolerance: float = 1e-9
    first_step: float = 0.02
    smallest_step: float = 1e-6
    largest_step: float = 0.07
    target_iterations: int = 4
    most_iterations: int = 12
    most_solutions: int = 5000

    def __post_init__(self) -> None:
        """Refuse what no path can be followed with."""
        for name, value in vars(self).items():
            if not value > 0:
                raise ValueError(f"{name} is {value}: it must be positive")


@dataclass(frozen=True)
class Solution:
    """A point on a path: unknown, parameter, corrections it took, and whether it solves."""

    x: Vector
    p: float
    iterations: int
    converged: bool
    located: bool = False
    """Whether it was placed where the event function vanishes."""


@dataclass
class Path:
    """Solutions in the order they were found.

    ``complete`` tells whether the far end of the window was reached; if not, ``reason`` says why.
    """

    solutions: list[Solution] = field(default_factory=list)
    complete: bool = False
    reason: str = ""


def newton(
    equations: Equations, x: Vector, p: float, control: StepControl
) -> tuple[Solution, NDArray[np.float64]]:
    """Solve the equations at a fixed parameter (eq. 2.37), halving corrections that do not help.

    Returns
    -------
    solution : Solution
        ``converged`` is false where ``most_iterations`` did not suffice.
    jacobian : ndarray
        Of the last correction, which differs from that at the solution by less than it corrected;
        where there was none, at the solution.
    """
    residual, form_jacobian = equations.evaluate(x, p)
    size, jacobian = np.linalg.norm(residual), form_jacobian()
    for iteration in range(control.most_iterations):
        limit = _smallest_residual(equations, control, x, jacobian)
        if iteration > 0 and size > limit:
            jacobian = form_jacobian()
        correction = _solve(jacobian, residual) if size > limit else None
        if correction is None:
            return Solution(x, p, iteration, bool(size <= limit)), jacobian
        for damping in (1.0, 0.5, 0.25, 0.125):
            trial = x - damping * correction
            residual, form_jacobian = equations.evaluate(trial, p)
            trial_size = np.linalg.norm(residual)
            if trial_size < size:
                break
        # a correction that does not help at any length may still lead out of a corner of the law
        x, size = trial, trial_size
    limit = _smallest_residual(equations, control, x, jacobian)
    return Solution(x, p, control.most_iterations, bool(size <= limit)), jacobian


def trace(
    equations: Equations,
    start: Vector,
    window: tuple[float, float],
    control: StepControl,
    *,
    scale: float,
    event: Event | None = None,
) -> Path:
    """Follow the solutions from one end of a parameter window to the other.

    Parameters
    ----------
    equations
        The system; ``renew`` is called after every accepted solution.
    start
        First guess of the unknown at ``window[0]``.
    window
        Parameter where the path starts and where it ends; it may run either way.
    control
        Step lengths and corrector limits.
    scale
        Change of the parameter that counts as much as doubling the unknown.
    event
        Where this function falls through zero, a solution is located and added to the path.

    Returns
    -------
    Path
        With all solutions to the point where the path ended. Not reaching the end is told in
        ``complete`` and ``reason``, not raised.
    """
    return _Tracer(equations, control, scale, event).run(start, *window)


@dataclass(frozen=True)
class _Station:
    """A solution to step from: where it is, how distances count there, and which way leads on."""

    x: Vector
    p: float
    weights: Vector
    tangent: Vector

    def at(self, offset: Vector) -> tuple[Vector, float]:
        moved = offset / self.weights
        return self.x + moved[:-1], self.p + float(moved[-1])


class _Corrected(NamedTuple):
    """A solution found on a sphere, a Jacobian there, and the way in unweighted coordinates."""

    solution: Solution
    jacobian: NDArray[np.float64]
    way: Vector


@dataclass
class _Tracer:
    """One continuation run."""

    equations: Equations
    control: StepControl
    parameter_scale: float
    event: Event | None
    path: Path = field(default_factory=Path)
    largest: float = 0.0
    came: Vector | None = None
    """The last way that led on."""
    behind: float = 0.0
    """How far back of its end the path is, against that way."""
    renewed: bool = False
    """Whether renewals change what the unknown means."""
    expected: tuple[Vector, float] | None = None
    """Fixed form of the unknown, and parameter, that the last renewal looked at."""
    arrived: float = 0.0
    """The event function at the last solution, in the terms in which it was found."""

    def run(self, start: Vector, begin: float, end: float) -> Path:
        towards = float(np.sign(end - begin))
        station = self._begin(start, begin, towards)
        if not self.path.solutions[0].converged:
            return self._stop("no solution found at the start of the window")
        step = min(self.control.first_step, self.control.largest_step)
        recentred, reason = False, ""
        while len(self.path.solutions) < self.control.most_solutions:
            if step < self.control.smallest_step:
                return self._stop(reason)
            found = self._correct(station, step)
            if found is not None and self.equations.repeats_steps:
                station, found = self._agreed(station, step, found)
            if found is None:
                reason = "no solution found near the last one"
                if self.equations.looks_ahead:
                    station, step = self._nearer(station), step * 0.5
                    continue
                if recentred:
                    step *= 0.5
                station, recentred = self._recentred(station), True
                continue
            solution = found.solution
            way = self._way_from_last(solution, station.weights[0])
            behind = self._behind_after(way)
            # without a renewal no unknown wavers, so what leads back is a curve passed too fast
            too_fast = behind > 0 and not self.renewed and step > _CORNER
            if np.linalg.norm(way) > _JUMP or behind > _WAVER or too_fast:
                reason = "the path would jump or turn back"
                step *= 0.5
                if self.equations.looks_ahead:
                    station = self._nearer(station)
                continue
            if (solution.p - begin) * towards < 0:
                return self._stop("the path returned to the start of the window")
            event = self._event_within(station, step, found)
            if event is not None and (event.p - end) * towards < 0:
                self.path.solutions.append(event)
            if (solution.p - end) * towards >= 0:
                return self._finish(station, solution, end)
            basis, fixed = self.equations.basis, self.equations.to_fixed(solution.x)
            effort = (self.control.target_iterations + 1) / (solution.iterations + 1)
            next_step = min(step * float(np.clip(effort, 0.5, 2.0)), self.control.largest_step)
            if self.equations.looks_ahead:
                self.arrived = self._event_after(station, found)
            onward = self._settle(*found, next_step / step)
            if self._renewal_passes_event(basis, station, found, onward):
                if step > max(_EVENT_ARC, 2 * self.control.smallest_step):
                    self.equations.basis = basis
                    step *= 0.5
                    continue
                solution = replace(solution, located=True)
            self.path.solutions.append(replace(solution, x=fixed))
            self.behind = behind if self.renewed else 0.0
            self.came = way if self.behind == 0 else self.came
            recentred, station, step = False, onward, next_step
        return self._stop("the path has more solutions than allowed")

    def _begin(self, start: Vector, begin: float, towards: float) -> _Station:
        """Solve at the start, renewing the meaning of the unknown until that changes it no more."""
        way = np.append(np.zeros_like(start), towards)
        # half way each time where renewals look ahead, for the reason given in _agreed
        share = 0.5 if self.equations.looks_ahead else 1.0
        expected = self.equations.to_fixed(start)
        for _ in range(_MOST_RENEWALS):
            solution, jacobian = newton(self.equations, start, begin, self.control)
            solved = self.equations.to_fixed(solution.x)
            expected = expected + share * (solved - expected)
            station = self._station(solution.x, begin, jacobian, way)
            renewed = self._renewed(station, way, (expected, begin))
            if renewed is None:
                break
            start, self.renewed = renewed.x, True
            change = np.linalg.norm(self.equations.to_fixed(start) - solved)
            if change <= _SETTLED * np.linalg.norm(solved):
                break
        solution, jacobian = newton(self.equations, start, begin, self.control)
        self._record(solution)
        return self._station(solution.x, begin, jacobian, way)

    def _settle(
        self, solution: Solution, jacobian: NDArray[np.float64], way: Vector, further: float
    ) -> _Station:
        """Step on from an accepted solution, re-expressed for going so many times as far."""
        station = self._station(solution.x, solution.p, jacobian, way)
        fixed, p, last = self.equations.to_fixed(solution.x), solution.p, self.path.solutions[-1]
        fixed, p = fixed + further * (fixed - last.x), p + further * (p - last.p)
        renewed = self._renewed(station, way, (fixed, p))
        self.renewed = self.renewed or renewed is not None
        return renewed or station

    def _renewed(
        self, station: _Station, way: Vector, ahead: tuple[Vector, float]
    ) -> _Station | None:
        """The station re-expressed, None where the unknown keeps its meaning."""
        self.expected = ahead
        renewed = self.equations.renew(station.x, station.p, way[:-1], ahead)
        if renewed is None:
            return None
        x, along = renewed
        _, form_jacobian = self.equations.evaluate(x, station.p)
        return self._station(x, station.p, form_jacobian(), np.append(along, way[-1]))

    def _station(self, x: Vector, p: float, jacobian: NDArray[np.float64], way: Vector) -> _Station:
        size = float(np.linalg.norm(x))
        self.largest = max(self.largest, size)
        size = max(size, _SMALL * self.largest) or 1.0
        weights = np.append(np.full_like(x, 1 / size), 1 / self.parameter_scale)
        return _Station(x, p, weights, self._tangent(x, p, jacobian, weights, way))

    def _tangent(
        self, x: Vector, p: float, jacobian: NDArray[np.float64], weights: Vector, way: Vector
    ) -> Vector:
        """Unit tangent of the path, in weighted coordinates, that leads on the way it came.

        The source takes the direction from the sign of det J (2.47). Bordering the derivatives
        with the way the path came says the same, and needs no determinant that over- or underflows.
        """
        came = way * weights
        derivative = self._derivative(x, p, jacobian, weights)
        derivative /= np.linalg.norm(derivative, axis=1, keepdims=True)
        unit = np.zeros(weights.size)
        unit[-1] = 1.0
        tangent = _solve(np.vstack([derivative, came / np.linalg.norm(came)]), unit)
        if tangent is None:  # the path turns at a right angle here: go on as it came
            tangent = came
        return tangent / np.linalg.norm(tangent)

    def _derivative(
        self, x: Vector, p: float, jacobian: NDArray[np.float64], weights: Vector
    ) -> NDArray[np.float64]:
        """Derivative of the residual by unknown and parameter, in weighted coordinates."""
        by_parameter = self.equations.parameter_derivative(x, p)
        return np.column_stack([jacobian, by_parameter]) / weights

    def _correct(self, station: _Station, step: float, sharp: bool = False) -> _Corrected | None:
        """Solve on the sphere of radius ``step`` around a station, ahead along its tangent.

        The Jacobian is that of the last correction, or, if it is to be ``sharp``, that at the
        solution. None where the corrector fails, strays or turns back.
        """
        offset, jacobian = step * station.tangent, None
        for iteration in range(self.control.most_iterations + 1):
            x, p = station.at(offset)
            residual, form_jacobian = self.equations.evaluate(x, p)
            if jacobian is None:
                jacobian = form_jacobian()
            sphere = offset @ offset / step - step
            limit = _smallest_residual(self.equations, self.control, x, jacobian)
            if np.linalg.norm(residual) <= limit and abs(sphere) <= 1e-3 * step:
                if offset @ station.tangent < 0.5 * step:
                    return None
                solution, way = Solution(x, p, iteration, True), offset / station.weights
                return _Corrected(solution, form_jacobian() if sharp else jacobian, way)
            if iteration > 0:
                jacobian = form_jacobian()
            derivative = self._derivative(x, p, jacobian, station.weights)
            correction = _solve(
                np.vstack([derivative, 2 * offset / step]), np.append(residual, sphere)
            )
            if correction is None or np.linalg.norm(correction) > 2 * step:
                return None
            offset = offset - correction
        return None

    def _nearer(self, station: _Station) -> _Station:
        """The station for a step half as long, renewed where that is expected to lead."""
        (expected, p), last = self.expected, self.path.solutions[-1]
        ahead = (expected + last.x) / 2, (p + last.p) / 2
        return self._renewed(station, station.tangent / station.weights, ahead) or station

    def _agreed(
        self, station: _Station, step: float, found: _Corrected | None
    ) -> tuple[_Station, _Corrected | None]:
        """The step made anew until it leads to where the renewal expected it to.

        What is expected and what is found may answer each other with opposite signs, so that going
        all the way would swing. How far to go is learnt from the last two tries (Irons and Tuck,
        Int. J. Numer. Meth. Engng 1, 1969).
        """
        share, last_gap = 0.5, None
        for _ in range(_LOOKS):
            if found is None:
                break
            fixed, p = self.equations.to_fixed(found.solution.x), found.solution.p
            expected, at = self.expected
            gap = fixed - expected
            if np.linalg.norm(gap) <= _AGREED * step * np.linalg.norm(fixed):
                break
            if last_gap is not None and (change := gap - last_gap).any():
                learnt = -share * (last_gap @ change) / (change @ change)
                share = float(np.clip(learnt, *_SHARES))
            last_gap = gap
            ahead = expected + share * gap, at + share * (p - at)
            station = self._renewed(station, station.tangent / station.weights, ahead) or station
            found = self._correct(station, step)
        return station, found

    def _way_from_last(self, solution: Solution, weight: float) -> Vector:
        """The way from the last recorded solution, in weighted coordinates no renewal changes."""
        last = self.path.solutions[-1]
        change = self.equations.to_fixed(solution.x) - last.x
        return np.append(change * weight, (solution.p - last.p) / self.parameter_scale)

    def _behind_after(self, way: Vector) -> float:
        """How far back the path would be after a way: a renewed unknown may tempt it to turn."""
        if self.came is None:
            return 0.0
        progress = float(way @ self.came) / float(np.linalg.norm(self.came))
        return max(0.0, self.behind - progress)

    def _recentred(self, station: _Station) -> _Station:
        """Put a station back on the path, which a renewed unknown has left.

        Without a renewal it is on the path already, and stays.
        """
        offset = np.zeros_like(station.tangent)
        for _ in range(self.control.most_iterations):
            x, p = station.at(offset)
            residual, form_jacobian = self.equations.evaluate(x, p)
            jacobian = form_jacobian()
            limit = _smallest_residual(self.equations, self.control, x, jacobian)
            if np.linalg.norm(residual) <= limit:
                way = station.tangent / station.weights
                tangent = self._tangent(x, p, jacobian, station.weights, way)
                return _Station(x, p, station.weights, tangent)
            derivative = self._derivative(x, p, jacobian, station.weights)
            correction = _solve(np.vstack([derivative, station.tangent]), np.append(residual, 0.0))
            if correction is None:
                break
            offset = offset - correction
        return station

    def _finish(self, station: _Station, beyond: Solution, end: float) -> Path:
        """Place the last solution exactly on the end of the window."""
        share = (end - station.p) / (beyond.p - station.p)
        guess = station.x + share * (beyond.x - station.x)
        last, _ = newton(self.equations, guess, end, self.control)
        self._record(last)
        self.path.complete = last.converged
        return self.path if last.converged else self._stop("no solution at the window's end")

    def _event_within(self, station: _Station, step: float, found: _Corrected) -> Solution | None:
        """The solution within a step, in fixed terms, at which the event falls through zero."""
        if self.event is None:
            return None
        if self.equations.looks_ahead:
            return self._event_looked_at(station, step, found)
        if self._event_at(station) <= 0 or self._event_after(station, found) > 0:
            return None
        # a renewal has left the station beside the path, too far for the shortest arcs
        event = self._located(station, step, found) or self._located(self._recentred(station), step)
        return event and replace(event, x=self.equations.to_fixed(event.x))

    def _event_looked_at(
        self, station: _Station, step: float, found: _Corrected
    ) -> Solution | None:
        """The same where renewals look ahead: in terms renewed at the event itself."""
        if self.arrived <= 0 or self._event_after(station, found) > 0:
            return None
        basis, expected, event = self.equations.basis, self.expected, found.solution
        way, last = station.tangent / station.weights, self.equations.to_fixed(event.x)
        for _ in range(_LOOKS):
            station = self._renewed(station, way, (last, event.p)) or station
            way = station.tangent / station.weights
            # an event that is already past where it is looked for lies at one end of the step
            event = self._located(station, step) or replace(event, located=True)
            fixed = self.equations.to_fixed(event.x)
            if np.linalg.norm(fixed - last) <= _SETTLED * np.linalg.norm(fixed):
                break
            last = (fixed + last) / 2
        self.equations.basis, self.expected = basis, expected
        return replace(event, x=fixed)

    def _located(
        self, station: _Station, step: float, found: _Corrected | None = None
    ) -> Solution | None:
        """The solution at an event between a station and a step, whose end may be known."""
        before = self._event_at(station)
        if before <= 0:
            return Solution(station.x, station.p, 0, True, located=True)
        tried: dict[float, Solution] = {}

        def event_along(arc: float) -> float:
            if arc == 0:
                return before
            at_end = found is not None and arc == step
            corrected = found if at_end else self._correct(station, arc, sharp=True)
            if corrected is None:
                raise _Lost
            tried[arc] = replace(corrected.solution, located=True)
            return self._event_after(station, corrected)

        try:
            return tried.get(brentq(event_along, 0.0, step, xtol=1e-6 * step, rtol=1e-9))
        except (_Lost, ValueError):  # no solution there, or none that the event falls before
            return None

    def _renewal_passes_event(
        self, basis: object, station: _Station, found: _Corrected, onward: _Station
    ) -> bool:
        """Whether the event function falls through zero not in a step but by renewing after it."""
        if self.event is None or self.equations.looks_ahead or self._event_at(onward) > 0:
            return False
        renewed, self.equations.basis = self.equations.basis, basis
        arrived = self._event_after(station, found)
        self.equations.basis = renewed
        return arrived > 0

    def _event_at(self, station: _Station) -> float:
        return self.event(station.x, (station.tangent / station.weights)[:-1])

    def _event_after(self, station: _Station, found: _Corrected) -> float:
        x, p = found.solution.x, found.solution.p
        tangent = self._tangent(x, p, found.jacobian, station.weights, found.way)
        return self.event(x, (tangent / station.weights)[:-1])

    def _record(self, solution: Solution) -> None:
        self.path.solutions.append(replace(solution, x=self.equations.to_fixed(solution.x)))

    def _stop(self, reason: str) -> Path:
        self.path.reason = reason
        return self.path


class _Lost(Exception):
    """The corrector failed while an event was being located."""


def _smallest_residual(
    equations: Equations, control: StepControl, x: Vector, jacobian: NDArray[np.float64]
) -> float:
    """The residual that counts as zero: by the tolerance, or the rounding of its own terms.

    At a sharp resonance the terms are orders of magnitude larger than what they balance.
    """
    terms = float(np.linalg.norm(abs(jacobian) @ abs(x)))
    return max(control.tolerance * equations.residual_scale, _ROUNDING * terms)


def _solve(matrix: NDArray[np.float64], right: Vector) -> Vector | None:
    try:
        solution = np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return None
    return solution if np.all(np.isfinite(solution)) else None
