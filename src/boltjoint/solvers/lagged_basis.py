"""Arc-length continuation in a basis that depends on the response and lags behind it.

The unknown is expressed in a basis that is updated once for each solution, so it changes its
meaning along the branch; solutions are recorded in fixed coordinates. The basis is that of the last
solution, or, where it is predictive, that of the point expected next; where it is implicit too, a
step is repeated until the basis belongs to the solution that it leads to.

A basis held during a step may fold, or have no solution ahead, where the full equations have one.
Where such a basis is implicit, its solutions are those of the full equations, and the branch is
followed in these until the basis leads on again.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from boltjoint.solvers.arc_length import Corrected, Corrector, Station, Tracer, arc_from, observed
from boltjoint.solvers.equations import Equations, Path, Quantity, Solution, StepControl, Vector
from boltjoint.solvers.maxima import Arc, Maxima, Observation
from boltjoint.solvers.newton import newton

#: updates after which a branch starts, settled or not
_MOST_UPDATES = 100

#: relative change of a solution that its basis no longer causes
_SETTLED = 1e-6

#: a longer step [arc length] between two solutions is a jump to elsewhere
_JUMP = 0.2

#: distance [arc length] by which a branch in a lagging basis may fall back without turning back
_BACKTRACKING = 0.02

#: relative change of a solution at a maximum that its basis no longer causes
_LOCATED = 1e-9

#: relative change of a sample beyond which it does not lag but lies elsewhere
_LAGGED = 0.05

#: times that a step is repeated in an updated basis, and at a maximum
_MOST_REPEATS = 8
_MOST_REPEATS_AT_MAXIMUM = 30

#: least and largest relaxation factor of the fixed-point iteration on the basis
_RELAXATION = 0.05, 1.0

#: change of an unknown, over the step, between what an update expected and what is found
_AGREED = 0.05

#: residual of the full equations, relative to its scale, beyond which a basis has gone astray
_STRAYED = 0.05

#: a shorter step [arc length] costs more in a basis than in the full equations
_SHORTEST = 1e-3

#: a step is shortened so many times as most before the full equations are followed
_MOST_SHORTENED = 4

#: steps in the full equations before the basis is tried again; twice as many each time in vain
_FULL_STEPS = 5


class LaggedEquations(Equations):
    """Equations whose unknown is expressed in a basis that depends on the response."""

    predictive: bool
    """Whether the basis is that of the point expected next, not of the last solution."""

    implicit: bool
    """Whether a step is repeated until the basis belongs to the solution that it leads to."""

    full: Equations | None
    """The equations in fixed coordinates that an implicit basis solves; else None."""

    basis: object
    """What the unknown presently stands for; it may be set back."""

    def update(self, q: Vector, p: float) -> None:
        """Make the basis that of a response in fixed coordinates."""

    def from_fixed(self, q: Vector) -> Vector:
        """The unknown that is nearest to a response in fixed coordinates."""

    def to_fixed(self, x: Vector) -> Vector:
        """The response in fixed coordinates."""

    def change_from_fixed(self, dq: Vector) -> Vector:
        """A change of the response as one of the unknown."""

    def change_to_fixed(self, dx: Vector) -> Vector:
        """A change of the unknown as one of the response."""


def trace(
    equations: LaggedEquations,
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
        The system in its basis.
    start
        Initial guess of the response in fixed coordinates.
    window, control, scale, maximise, begin
        As for ``arc_length.trace``; the quantity is one of the fixed coordinates.

    Returns
    -------
    Path
        In fixed coordinates.
    """
    scale_at = scale if callable(scale) else lambda _: scale
    tracer = _Tracer(equations, control, scale_at, window, maximise)
    return tracer.run(start, window[0] if begin is None else begin)


class _Origin(NamedTuple):
    """A solution in fixed coordinates from which the branch goes on, and in what direction."""

    q: Vector
    p: float
    direction: Vector


class _Tracer:
    """One continuation run."""

    def __init__(
        self,
        equations: LaggedEquations,
        control: StepControl,
        scale: Callable[[float], float],
        window: tuple[float, float],
        maximise: Quantity | None,
    ) -> None:
        self.equations, self.control, self.window = equations, control, window
        self.corrector = Corrector(equations, control, scale)
        self.full = equations.full and Corrector(equations.full, control, scale)
        self.path = Path()
        self.maxima = None if maximise is None else Maxima(self.path, maximise, self._arc_from)
        self.towards = float(np.sign(window[1] - window[0]))
        self.step = min(control.first_step, control.largest_step)
        self.full_steps = _FULL_STEPS

    def run(self, start: Vector, p: float) -> Path:
        """The branch; samples around its maxima are put on it, beside which lagging ones lie."""
        self._trace(start, p)
        if self.full is not None and self.maxima is not None:
            _polish_maxima(self.path, self.maxima.quantity, self.full.equations, self.control)
        return self.path

    def _trace(self, start: Vector, p: float) -> Path:
        if not self._begin(start, p):
            return self._stop("no solution found at the start of the window")
        while len(self.path.solutions) < self.control.maximum_solutions:
            found, reason = self._next()
            if found is None:
                if self.full is None:
                    return self._stop(reason)
                if not self._follow_full():
                    return self.path
            elif (found.solution.p - self.window[0]) * self.towards < 0:
                return self._stop("the branch returned to the start of the window")
            elif (found.solution.p - self.window[1]) * self.towards >= 0:
                return self._finish(found.solution)
            else:
                self._accept(found)
        return self._stop("the branch has more solutions than allowed")

    def _begin(self, start: Vector, p: float) -> bool:
        """Solve at the start, in a basis updated until that changes the solution no more."""
        equations = self.equations
        # half way each time where the basis is predictive, for the reason given in _repeat
        share = 0.5 if equations.predictive else 1.0
        x, expected = equations.from_fixed(start), start
        for _ in range(_MOST_UPDATES):
            solution, _ = newton(equations, x, p, self.control)
            solved = equations.to_fixed(solution.x)
            expected = expected + share * (solved - expected)
            equations.update(expected, p)
            x = equations.from_fixed(solved)
            change = np.linalg.norm(equations.to_fixed(x) - solved)
            if change <= _SETTLED * np.linalg.norm(solved):
                break
        solution, _ = newton(equations, x, p, self.control)
        q = equations.to_fixed(solution.x)
        self.path.solutions.append(solution._replace(x=q, full=False))
        self.origin = _Origin(q, p, np.append(np.zeros_like(q), self.towards))
        self.secant, self.behind = None, 0.0
        self.expected = expected, p
        self.station = self._station()
        self._sample(0.0)
        return solution.converged

    def _next(self) -> tuple[Corrected | None, str]:
        """The solution a step ahead, which becomes shorter until there is one; else why not."""
        predictive, projected, reason = self.equations.predictive, False, ""
        shortest = self.control.smallest_step
        if self.full is not None:
            shortest = max(_SHORTEST, self.step / _MOST_SHORTENED)
        while self.step >= shortest:
            found = self.corrector.correct(self.station, self.step)
            if self.equations.implicit:
                found = self._repeat(found, self.step, _AGREED * self.step)
            if found is not None and self._is_strayed(found):
                found = None
            if found is not None:
                secant = self._secant_to(found)
                if np.linalg.norm(secant) <= _JUMP and self._behind(secant) <= _BACKTRACKING:
                    return found, ""
                reason = "the branch would jump or turn back"
            else:
                reason = "no solution found near the last one"
                if not (predictive or projected):
                    self._project()
                    projected = True
                    continue
            self.step *= 0.5
            if predictive:
                (q, p), origin = self.expected, self.origin
                self._update((q + origin.q) / 2, (p + origin.p) / 2)
        return None, reason

    def _repeat(
        self,
        found: Corrected | None,
        step: float,
        tolerance: float,
        most: int = _MOST_REPEATS,
    ) -> Corrected | None:
        """The step repeated until it leads to where its basis was updated.

        What is expected and what is found may answer each other with opposite signs, so that going
        all the way would oscillate. The relaxation factor is learnt from the last two tries (Irons
        and Tuck, Int. J. Numer. Meth. Engng 1, 1969).
        """
        share, last_gap = 0.5, None
        for _ in range(most):
            if found is None:
                return None
            q, at = self.expected
            gap = self.equations.to_fixed(found.solution.x) - q
            if np.linalg.norm(gap) <= tolerance * np.linalg.norm(q + gap):
                return found
            if last_gap is not None and (change := gap - last_gap).any():
                learnt = -share * (last_gap @ change) / (change @ change)
                share = float(np.clip(learnt, *_RELAXATION))
            last_gap = gap
            self._update(q + share * gap, at + share * (found.solution.p - at))
            found = self.corrector.correct(self.station, step)
        return None

    def _is_strayed(self, found: Corrected) -> bool:
        """Whether the basis solves something else than the full equations."""
        if self.full is None:
            return False
        full, solution = self.full.equations, found.solution
        residual, _ = full.evaluate(self.equations.to_fixed(solution.x), solution.p)
        return bool(np.linalg.norm(residual) > _STRAYED * full.residual_scale)

    def _accept(self, found: Corrected) -> None:
        """Add a solution to the path, and go on from it in an updated basis."""
        equations, control, solution = self.equations, self.control, found.solution
        secant = self._secant_to(found)
        self.behind = self._behind(secant)
        self.secant = secant if self.behind == 0 else self.secant
        q = equations.to_fixed(solution.x)
        self._locate(found)
        effort = (control.target_iterations + 1) / (solution.iterations + 1)
        reach = self.step
        self.step = min(reach * float(np.clip(effort, 0.5, 2.0)), control.largest_step)
        direction = np.append(equations.change_to_fixed(found.offset[:-1]), found.offset[-1])
        self.path.solutions.append(solution._replace(x=q, full=False))
        self._go_on(_Origin(q, solution.p, direction), self.step / reach)
        self._sample(reach)
        self.full_steps = max(_FULL_STEPS, self.full_steps // 2)

    def _go_on(self, origin: _Origin, further: float) -> None:
        """Go on from a solution, for the next step so many times as far as the last one."""
        before, self.origin = self.origin, origin
        if self.equations.predictive:
            q, p = origin.q - before.q, origin.p - before.p
            self._update(origin.q + further * q, origin.p + further * p)
        else:
            self._update(origin.q, origin.p)

    def _update(self, q: Vector, p: float) -> None:
        """Update the basis at a response, and express in it where the branch goes on."""
        self.equations.update(q, p)
        self.expected = q, p
        self.station = self._station()

    def _station(self) -> Station:
        q, p, direction = self.origin
        x = self.equations.from_fixed(q)
        along = np.append(self.equations.change_from_fixed(direction[:-1]), direction[-1])
        _, jacobian_at = self.equations.evaluate(x, p)
        return self.corrector.station(x, p, jacobian_at(), along)

    def _project(self) -> None:
        """Put the station back on the branch, which the update of the basis has moved."""
        found = self.corrector.project(self.station)
        if found is not None:
            solution, jacobian = found
            weights, tangent = self.station.weights, self.station.tangent
            x, p = solution.x, solution.p
            tangent = self.corrector.tangent(x, p, jacobian, weights, tangent / weights)
            self.station = Station(x, p, weights, tangent)

    def _secant_to(self, found: Corrected) -> Vector:
        """The way from the last solution in weighted fixed coordinates."""
        change = self.equations.to_fixed(found.solution.x) - self.origin.q
        by_parameter = (found.solution.p - self.origin.p) * self.station.weights[-1]
        return np.append(change * self.station.weights[0], by_parameter)

    def _behind(self, secant: Vector) -> float:
        """How far back the branch would be: an updated basis may tempt it to turn."""
        if self.secant is None:
            return 0.0
        progress = float(secant @ self.secant) / float(np.linalg.norm(self.secant))
        return max(0.0, self.behind - progress)

    def _follow_full(self) -> bool:
        """Follow the full equations for some steps; whether the branch goes on behind them."""
        origin = self.origin
        _, jacobian_at = self.full.equations.evaluate(origin.q, origin.p)
        station = self.full.station(origin.q, origin.p, jacobian_at(), origin.direction)
        projected = self.full.project(station)
        if projected is None:
            self._stop("no solution found near the last one")
            return False
        solution, jacobian = projected
        tracer = Tracer(self.full, self.window, self.path, self.maxima)
        tracer.step = self.step
        tracer.resume(solution, jacobian, origin.direction)
        for _ in range(self.full_steps):
            before = tracer.station
            if not tracer.advance():
                return False
        self.full_steps *= 2
        last, self.step = tracer.station, max(tracer.step, 2 * _SHORTEST)
        direction = np.append(last.x - before.x, last.p - before.p)
        self.origin = _Origin(before.x, before.p, direction)
        self._go_on(_Origin(last.x, last.p, direction), 1.0)
        self.secant, self.behind = None, 0.0
        return True

    def _finish(self, beyond: Solution) -> Path:
        """Place the last solution exactly on the end of the window."""
        station, end = self.station, self.window[1]
        share = (end - station.p) / (beyond.p - station.p)
        guess = station.x + share * (beyond.x - station.x)
        last, _ = newton(self.equations, guess, end, self.control)
        self.path.solutions.append(last._replace(x=self.equations.to_fixed(last.x), full=False))
        if not last.converged:
            return self._stop("no solution found at the end of the window")
        self.origin = _Origin(self.path.solutions[-1].x, end, self.origin.direction)
        self._sample(share * self.step)
        self.path.complete = True
        return self.path

    def _stop(self, reason: str) -> Path:
        self.path.reason = reason
        return self.path

    def _sample(self, reach: float) -> None:
        if self.maxima is not None:
            self.maxima.sample(self.origin, reach)

    def _locate(self, found: Corrected) -> None:
        """Add a maximum by the slope in the held basis, where that is the only slope there is."""
        if self.maxima is None or self.equations.predictive:
            return
        quantity = _InBasis(self.maxima.quantity, self.equations)
        station = self.station
        slope = quantity.slope(station.x, (station.tangent / station.weights)[:-1])
        if slope > 0 >= observed(self.corrector, quantity, station, found).slope:
            arc = self._held(arc_from(self.corrector, quantity, station))
            highest = self.maxima.locate(arc, slope, self.step)
            if highest is not None:
                self.path.solutions.append(highest)

    def _held(self, arc: Arc) -> Arc:
        """An arc in the held basis, its solutions in fixed coordinates."""

        def fixed(length: float) -> Observation | None:
            found = arc(length)
            if found is None:
                return None
            x = self.equations.to_fixed(found.solution.x)
            return found._replace(solution=found.solution._replace(x=x, full=False))

        return fixed

    def _arc_from(self, begin: _Origin | Station, end: _Origin | Station) -> Arc:
        """The branch by arc length from one solution towards the next, in bases of its own."""
        if isinstance(begin, Station):
            return arc_from(self.full, self.maxima.quantity, begin)
        q, p = end[0] - begin.q, end[1] - begin.p
        reach = np.linalg.norm(np.append(q * self.station.weights[0], p * self.station.weights[-1]))

        def arc(length: float) -> Observation | None:
            kept = self.equations.basis, self.expected, self.origin, self.station
            self.origin, share = begin, length / reach
            self._update(begin.q + share * q, begin.p + share * p)
            found = self.corrector.correct(self.station, length)
            found = self._repeat(found, length, _LOCATED, _MOST_REPEATS_AT_MAXIMUM)
            observation = None if found is None else self._observed(found)
            self.equations.basis, self.expected, self.origin, self.station = kept
            return observation

        return arc

    def _observed(self, found: Corrected) -> Observation:
        """A solution with the slope along the full equations, unknown where there are none."""
        quantity, p = self.maxima.quantity, found.solution.p
        q, slope = self.equations.to_fixed(found.solution.x), np.nan
        if self.full is not None:
            direction = np.append(q - self.origin.q, p - self.origin.p)
            _, jacobian_at = self.full.equations.evaluate(q, p)
            station = self.full.station(q, p, jacobian_at(), direction)
            slope = quantity.slope(q, (station.tangent / station.weights)[:-1])
        return Observation(found.solution._replace(x=q, full=False), quantity.value(q), slope)


def _polish_maxima(
    path: Path, quantity: Quantity, equations: Equations, control: StepControl
) -> None:
    """Solve the full equations at samples that are higher than their neighbours, and at these.

    What a sample lags must not make it higher than the maximum located beside it. What is still
    higher than both neighbours then is a maximum.
    """
    solutions, polished = path.solutions, set()
    while True:
        values = [quantity.value(each.x) for each in solutions]
        highs = [
            i for i in range(1, len(values) - 1) if values[i] >= max(values[i - 1], values[i + 1])
        ]
        near = {i + step for i in highs for step in (-1, 0, 1)} - polished
        if not near:
            break
        polished |= near
        for i in near:
            before = solutions[i]
            if before.located or before.full:
                continue
            found, _ = newton(equations, before.x, before.p, control)
            change = np.linalg.norm(found.x - before.x)
            if found.converged and change <= _LAGGED * np.linalg.norm(before.x):
                solutions[i] = found._replace(iterations=before.iterations)
    for i in highs:
        solutions[i] = solutions[i]._replace(located=True)


class _InBasis(NamedTuple):
    """A quantity of the fixed coordinates, by the unknown of a basis."""

    quantity: Quantity
    equations: LaggedEquations

    def value(self, x: Vector) -> float:
        return self.quantity.value(self.equations.to_fixed(x))

    def slope(self, x: Vector, dx: Vector) -> float:
        return self.quantity.slope(self.equations.to_fixed(x), self.equations.change_to_fixed(dx))
