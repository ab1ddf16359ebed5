"""Arc-length continuation of r(x, p) = 0 over a parameter window.

A branch is followed on spheres around its last solution (Crisfield 1981; eq. 2.39 to 2.42 of the
thesis), so it passes turning points. Distances are measured relative to the size of the last
solution, because a resonance spans orders of magnitude: ``|dx|^2 / |x|^2 + (dp / scale)^2``.

References
----------
M. A. Crisfield: A fast incremental/iterative solution procedure that handles "snap-through".
Computers and Structures 13 (1981) 55-62.
R. Seydel: Practical Bifurcation and Stability Analysis. Springer, third edition, 2010.
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: sections 2.1.4 and 2.1.5.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from boltjoint.solvers import corners
from boltjoint.solvers.equations import (
    Equations,
    Matrix,
    Path,
    Quantity,
    Solution,
    StepControl,
    Vector,
)
from boltjoint.solvers.maxima import Arc, Maxima, Observation
from boltjoint.solvers.newton import newton, smallest_residual, solve

#: a step that turns the branch by more than a right angle was too long to see the curve, unless it
#: is as short as this: then the branch has a corner there
_CORNER = 1e-3

#: longest step from which the ways on from a corner are sought
_CORNER_STEP = 1e-4

#: smallest cosine between the step and the predicted direction, off a corner
_FORWARD = 0.5

#: a solution this small against the largest on the branch is measured against that instead
_SMALL = 1e-3


class Station(NamedTuple):
    """A solution from which a step is taken: the weights of distances, and the unit tangent."""

    x: Vector
    p: float
    weights: Vector
    tangent: Vector

    def at(self, offset: Vector) -> tuple[Vector, float]:
        """Unknown and parameter at a weighted offset."""
        moved = offset / self.weights
        return self.x + moved[:-1], self.p + float(moved[-1])


class Corrected(NamedTuple):
    """A solution on a sphere, a Jacobian there, and the unweighted offset from the center."""

    solution: Solution
    jacobian: Matrix
    offset: Vector


@dataclass
class Corrector:
    """Predictor and corrector on spheres around solutions.

    Parameters
    ----------
    equations, control
        The system and its tolerances.
    scale
        Change of the parameter, by the parameter, that counts as much as doubling the unknown.
    """

    equations: Equations
    control: StepControl
    scale: Callable[[float], float]
    largest: float = 0.0
    """Largest size of the unknown so far."""

    def station(self, x: Vector, p: float, jacobian: Matrix, direction: Vector) -> Station:
        """A solution to step from, its tangent along an unweighted direction."""
        size = float(np.linalg.norm(x))
        self.largest = max(self.largest, size)
        size = max(size, _SMALL * self.largest) or 1.0
        weights = np.append(np.full_like(x, 1 / size), 1 / self.scale(p))
        return Station(x, p, weights, self.tangent(x, p, jacobian, weights, direction))

    def tangent(
        self, x: Vector, p: float, jacobian: Matrix, weights: Vector, direction: Vector
    ) -> Vector:
        """Unit tangent of the branch, in weighted coordinates, that leads on in a direction.

        The thesis takes the sense from the sign of det J (2.47). Bordering the derivatives with
        the direction says the same, and needs no determinant that over- or underflows.
        """
        along = direction * weights
        derivative = self.derivative(x, p, jacobian, weights)
        derivative /= np.linalg.norm(derivative, axis=1, keepdims=True)
        unit = np.zeros(weights.size)
        unit[-1] = 1.0
        tangent = solve(np.vstack([derivative, along / np.linalg.norm(along)]), unit)
        if tangent is None:  # the branch turns at a right angle here
            tangent = along
        return tangent / np.linalg.norm(tangent)

    def derivative(self, x: Vector, p: float, jacobian: Matrix, weights: Vector) -> Matrix:
        """Derivative of the residual by unknown and parameter, in weighted coordinates."""
        by_parameter = self.equations.parameter_derivative(x, p)
        return np.column_stack([jacobian, by_parameter]) / weights

    def correct(
        self,
        station: Station,
        step: float,
        start: Vector | None = None,
        *,
        sharp: bool = False,
    ) -> Corrected | None:
        """Solve on the sphere of radius ``step`` around a station.

        Parameters
        ----------
        station, step
            Center and radius.
        start
            Unit direction of the initial guess; by default the tangent, and then the solution must
            lie ahead of it.
        sharp
            Whether the Jacobian is evaluated at the solution; else it is that of the last
            correction.

        Returns
        -------
        Corrected or None
            None where the corrector fails, strays or turns back.
        """
        offset, jacobian = step * (station.tangent if start is None else start), None
        for iteration in range(self.control.maximum_iterations + 1):
            x, p = station.at(offset)
            residual, jacobian_at = self.equations.evaluate(x, p)
            if jacobian is None:
                jacobian = jacobian_at()
            sphere = offset @ offset / step - step
            limit = smallest_residual(self.equations, self.control, x, jacobian)
            if np.linalg.norm(residual) <= limit and abs(sphere) <= 1e-3 * step:
                if start is None and offset @ station.tangent < _FORWARD * step:
                    return None
                solution = Solution(x, p, iteration, True)
                jacobian = jacobian_at() if sharp else jacobian
                return Corrected(solution, jacobian, offset / station.weights)
            if iteration > 0:
                jacobian = jacobian_at()
            derivative = self.derivative(x, p, jacobian, station.weights)
            correction = solve(
                np.vstack([derivative, 2 * offset / step]), np.append(residual, sphere)
            )
            if correction is None or np.linalg.norm(correction) > 2 * step:
                return None
            offset = offset - correction
        return None

    def project(self, station: Station) -> tuple[Solution, Matrix] | None:
        """Solve in the plane across the tangent of a station that lies beside the branch.

        Returns
        -------
        tuple or None
            The solution and the Jacobian there; None where the corrector fails.
        """
        offset = np.zeros_like(station.tangent)
        for iteration in range(self.control.maximum_iterations):
            x, p = station.at(offset)
            residual, jacobian_at = self.equations.evaluate(x, p)
            jacobian = jacobian_at()
            limit = smallest_residual(self.equations, self.control, x, jacobian)
            if np.linalg.norm(residual) <= limit:
                return Solution(x, p, iteration, True), jacobian
            derivative = self.derivative(x, p, jacobian, station.weights)
            correction = solve(np.vstack([derivative, station.tangent]), np.append(residual, 0.0))
            if correction is None:
                return None
            offset = offset - correction
        return None

    def sharpened(self, station: Station) -> Station:
        """The station with the tangent of the Jacobian at its own solution."""
        _, jacobian_at = self.equations.evaluate(station.x, station.p)
        direction = station.tangent / station.weights
        tangent = self.tangent(station.x, station.p, jacobian_at(), station.weights, direction)
        return station._replace(tangent=tangent)


def trace(
    equations: Equations,
    start: Vector,
    window: tuple[float, float],
    control: StepControl,
    *,
    scale: float | Callable[[float], float],
    maximise: Quantity | None = None,
    begin: float | None = None,
) -> Path:
    """Follow the solutions from one end of a parameter window to the other.

    Parameters
    ----------
    equations
        The system; ``accept`` is called after every accepted solution.
    start
        Initial guess of the unknown at ``begin``.
    window
        Parameter where the branch starts and where it ends; it may run either way.
    control
        Step lengths and corrector limits.
    scale
        Change of the parameter that counts as much as doubling the unknown; a function of the
        parameter where it is not the same everywhere.
    maximise
        A quantity whose local maxima are located and added to the path.
    begin
        Parameter of the start, within the window; by default that where the window starts.

    Returns
    -------
    Path
        With all solutions to the point where the branch ended. Not reaching the end is told in
        ``complete`` and ``reason``, not raised.
    """
    corrector = Corrector(equations, control, scale if callable(scale) else lambda _: scale)
    path, maxima = Path(), None
    if maximise is not None:
        maxima = Maxima(path, maximise, lambda at, _: arc_from(corrector, maximise, at))
    tracer = Tracer(corrector, window, path, maxima)
    if tracer.start(start, window[0] if begin is None else begin):
        while tracer.advance():
            pass
    return path


class _WayOn(NamedTuple):
    """A way on from a corner that was not taken, and the state of the run before it."""

    solutions: tuple[Solution, ...]
    found: Corrected
    reach: float
    tracked: object


class Tracer:
    """Continuation of one branch, step by step.

    Where the branch has a corner with several ways on, the one farthest ahead is taken first; where
    that does not lead to the end of the window, the run goes back to the last such corner and takes
    the next.

    Parameters
    ----------
    corrector
        Predictor and corrector of the branch.
    window
        As for ``trace``.
    path
        To which solutions are added.
    maxima
        Where they are noted, to locate maxima; its samples are stations.
    """

    def __init__(
        self,
        corrector: Corrector,
        window: tuple[float, float],
        path: Path,
        maxima: Maxima | None = None,
    ) -> None:
        self.corrector, self.window, self.path, self.maxima = corrector, window, path, maxima
        self.step = min(corrector.control.first_step, corrector.control.largest_step)
        self.station: Station | None = None
        self._offset: Vector | None = None
        self._towards = float(np.sign(window[1] - window[0]))
        self._ways_on: list[_WayOn] = []
        self._first_attempt: Path | None = None
        self._taken = 0

    def start(self, x: Vector, p: float) -> bool:
        """Solve at the start; whether that succeeded."""
        solution, jacobian = newton(self.corrector.equations, x, p, self.corrector.control)
        if not solution.converged:
            self.path.solutions.append(solution)
            return self._stop("no solution found at the start of the window")
        self.accept(solution, jacobian, np.append(np.zeros_like(x), self._towards))
        return True

    def accept(
        self, solution: Solution, jacobian: Matrix, direction: Vector, reach: float = 0.0
    ) -> None:
        """Add a solution, reached by a step along an unweighted direction, and go on from it."""
        self._taken += 1
        self.path.solutions.append(solution)
        self.resume(solution, jacobian, direction)
        self._offset = direction if reach else None
        if self.maxima is not None:
            self.maxima.sample(self.station, reach)

    def resume(self, solution: Solution, jacobian: Matrix, direction: Vector) -> None:
        """Go on from a solution in an unweighted direction."""
        self.station = self.corrector.station(solution.x, solution.p, jacobian, direction)
        self.corrector.equations.accept(solution.x)

    def advance(self) -> bool:
        """Add the next solution to the path; whether the branch goes on behind it."""
        control = self.corrector.control
        if self._taken >= control.maximum_solutions:
            return self._stop("the branch has more solutions than allowed")
        found = self._next()
        if found is None:
            return self._elsewhere("no solution found near the last one")
        solution, (begin, end) = found.solution, self.window
        if (solution.p - begin) * self._towards < 0:
            return self._elsewhere("the branch returned to the start of the window")
        self._locate(found)
        if (solution.p - end) * self._towards >= 0:
            return self._finish(found)
        effort = (control.target_iterations + 1) / (solution.iterations + 1)
        reach = self.step
        self.step = min(reach * float(np.clip(effort, 0.5, 2.0)), control.largest_step)
        self.accept(solution, found.jacobian, found.offset, reach)
        return True

    def _next(self) -> Corrected | None:
        """The solution a step ahead, which becomes shorter until there is one."""
        control, sharp = self.corrector.control, False
        # there is a step that is short enough, whatever the shortest one is
        short, shortest = (max(step, 2 * control.smallest_step) for step in (_CORNER, _CORNER_STEP))
        while self.step >= control.smallest_step:
            found = self.corrector.correct(self.station, self.step)
            if found is None and not sharp:
                self.station, sharp = self.corrector.sharpened(self.station), True
                continue
            if found is None and self.step <= shortest:
                found = self._around_corner()
            if found is not None and (self.step <= short or not self._turns_back(found)):
                return found
            self.step *= 0.5
        return None

    def _turns_back(self, found: Corrected) -> bool:
        """Whether the branch has turned by more than a right angle since the step before."""
        if self._offset is None:
            return False
        weights = self.station.weights
        return float((found.offset * weights) @ (self._offset * weights)) < 0

    def _around_corner(self) -> Corrected | None:
        """The way on from a corner that leads farthest ahead; others are kept in reserve."""
        ways_on = corners.ways_on(self.corrector, self.station, self.step)
        before, tracked = tuple(self.path.solutions), self.corrector.equations.tracked
        self._ways_on += [
            _WayOn(before, other, self.step, tracked) for other in reversed(ways_on[1:])
        ]
        return ways_on[0] if ways_on else None

    def _elsewhere(self, reason: str) -> bool:
        """Go back to the last corner with another way on; stop where there is none."""
        if not self._ways_on:
            return self._stop(reason)
        if self._first_attempt is None:
            self._first_attempt = Path(list(self.path.solutions), reason=reason)
        before, found, self.step, self.corrector.equations.tracked = self._ways_on.pop()
        self.path.solutions[:] = before
        self.accept(found.solution, found.jacobian, found.offset, self.step)
        return True

    def _finish(self, found: Corrected) -> bool:
        """Place the last solution exactly on the end of the window."""
        station, beyond, end = self.station, found.solution, self.window[1]
        share = (end - station.p) / (beyond.p - station.p)
        guess = station.x + share * (beyond.x - station.x)
        last, _ = newton(self.corrector.equations, guess, end, self.corrector.control)
        if not last.converged:
            self.path.solutions.append(last)
            return self._stop("no solution found at the end of the window")
        self.path.solutions.append(last)
        if self.maxima is not None:
            self.maxima.sample(station, share * self.step)
        self.path.complete = True
        return False

    def _stop(self, reason: str) -> bool:
        if self._first_attempt is not None:
            self.path.solutions[:] = self._first_attempt.solutions
            reason = self._first_attempt.reason
        self.path.reason = reason
        return False

    def _locate(self, found: Corrected) -> None:
        """Add the maximum of the step to a solution, if the slope falls through zero in it."""
        if self.maxima is None:
            return
        quantity, station = self.maxima.quantity, self.station
        before = quantity.slope(station.x, (station.tangent / station.weights)[:-1])
        after = observed(self.corrector, quantity, station, found).slope
        if before <= 0 or after > 0:
            return
        arc = arc_from(self.corrector, quantity, station)
        highest = self.maxima.locate(arc, before, self.step)
        if highest is not None and (highest.p - self.window[1]) * self._towards < 0:
            self.path.solutions.append(highest)


def observed(
    corrector: Corrector, quantity: Quantity, station: Station, found: Corrected
) -> Observation:
    """A solution on a sphere around a station, with a quantity there and its slope."""
    x, p, weights = found.solution.x, found.solution.p, station.weights
    tangent = corrector.tangent(x, p, found.jacobian, weights, found.offset)
    slope = quantity.slope(x, (tangent / weights)[:-1])
    return Observation(found.solution, quantity.value(x), slope)


def arc_from(corrector: Corrector, quantity: Quantity, station: Station) -> Arc:
    """The branch by arc length from a station."""

    def arc(length: float) -> Observation | None:
        found = corrector.correct(station, length, sharp=True)
        return found and observed(corrector, quantity, station, found)

    return arc
