"""Arc-length continuation in one compiled loop: the regular course of ``arc_length.trace``.

Start, steps, location of maxima by their slope and the end of the window are here. What a branch
rarely needs is not: corners, steps onto other parts of the branch, a start by load stepping, maxima
that the slope does not show. A path that needs them is not complete, and ``arc_length`` follows the
branch instead. Its solutions are those of ``arc_length`` to rounding: there are two of the same on
purpose, since the many designs of a sweep take a fifth of the time here, or less
(``docs/benchmarks.md``).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import call, kept_loop, loop
from boltjoint.solvers.compiled_linear import Matrix, Vector, Work, copy_to, make_work, norm
from boltjoint.solvers.compiled_steps import (
    ORIENTATION,
    SCALE,
    SIZE,
    SLOPE,
    VALUE,
    Limits,
    P,
    Place,
    System,
    make_place,
    scale_at,
    size_of,
)
from boltjoint.solvers.equations import Solution, SolutionBranch
from boltjoint.solvers.step_control import CORNER_STEP, TURNING_STEP

#: solutions for which there is room at first
_ROOM = 512

#: more than Brent's method ever needs
_MOST_ITERATIONS = 100


class Path(NamedTuple):
    """Solutions of a path: the first ``size`` rows of the arrays.

    ``complete``: whether it took its regular course to its end: that of the window, or behind a
    maximum (``falls_to``).
    """

    x: Matrix
    p: Vector
    iterations: NDArray[np.int64]
    located: NDArray[np.bool_]
    size: int
    complete: bool

    def branch(self) -> SolutionBranch:
        """The path as ``arc_length.trace`` gives it."""
        rows = (column[: self.size].tolist() for column in (self.p, self.iterations, self.located))
        solutions = [
            Solution(x, p, iterations, True, located)
            for x, p, iterations, located in zip(self.x[: self.size], *rows, strict=True)
        ]
        return SolutionBranch(solutions, self.complete)


@loop
def _reach(
    system: System,
    here: Place,
    distance: float,
    limits: Limits,
    work: Work,
    place: Place,
) -> int:
    """Solve at a distance from a place, and settle there in its distances; as ``correct``."""
    call(system.correct, system, here, distance, limits, work)
    iterations = work.outcome[0]
    if iterations >= 0:
        p, size, scale = here.numbers[P], here.numbers[SIZE], here.numbers[SCALE]
        for j in range(work.x.size):
            place.arrival[j] = work.offset[j] * size
        place.arrival[-1] = work.offset[-1] * scale
        p += place.arrival[-1]
        call(system.form_jacobian, system.arrays, work.x, p, work.jacobian)
        call(system.settle, system, p, size, scale, work, place)
    return iterations


@loop
def _locate(
    system: System,
    here: Place,
    length: float,
    limits: Limits,
    work: Work,
    place: Place,
) -> int:
    """Settle where the slope is zero within a step, by Brent's method as ``scipy.optimize.brentq``.

    Iterations of the solution; -1 without one.
    """
    absolute, relative = limits.peak_tolerance * length, 1e-9
    before, at, other = 0.0, length, 0.0
    f_before, f_at, f_other = here.numbers[SLOPE], 0.0, 0.0
    last, move = 0.0, 0.0
    is_found = False
    for evaluation in range(_MOST_ITERATIONS):
        iterations = _reach(system, here, at, limits, work, place)
        if iterations < 0 or is_found:
            return iterations
        f_at = place.numbers[SLOPE]
        if evaluation == 0 and f_at > 0.0:
            return -1
        if f_before != 0.0 and f_at != 0.0 and (f_before < 0.0) != (f_at < 0.0):
            other, f_other = before, f_before
            last = move = at - before
        swapped = abs(f_other) < abs(f_at)
        if swapped:
            before, at, other = at, other, at
            f_before, f_at, f_other = f_at, f_other, f_at
        delta = (absolute + relative * abs(at)) / 2
        bisection = (other - at) / 2
        if f_at == 0.0 or abs(bisection) < delta:
            if not swapped:
                return iterations
            if not at > 0.0:
                return -1
            is_found = True
            continue
        attempt = np.inf
        if abs(last) > delta and abs(f_at) < abs(f_before):
            if before == other:
                attempt = -f_at * (at - before) / (f_at - f_before)
            else:
                d_before = (f_before - f_at) / (before - at)
                d_other = (f_other - f_at) / (other - at)
                attempt = -f_at * (f_other * d_other - f_before * d_before)
                attempt /= d_other * d_before * (f_other - f_before)
        if 2 * abs(attempt) < min(abs(last), 3 * abs(bisection) - delta):
            last, move = move, attempt
        else:
            last = move = bisection
        before, f_before = at, f_at
        if abs(move) > delta:
            at += move
        else:
            at += delta if bisection > 0 else -delta
    return -1


@loop
def _advance(
    system: System,
    here: Place,
    length: float,
    limits: Limits,
    work: Work,
    renewed: Place,
) -> tuple[int, float]:
    """The next solution, at half the length where the corrector fails or the branch turns back.

    Iterations of the solution ``work.x``, -1 without one, and the length.
    """
    corner = max(TURNING_STEP, 2 * limits.smallest_step)
    corner_step = max(CORNER_STEP, 2 * limits.smallest_step)
    size, scale, n = here.numbers[SIZE], here.numbers[SCALE], here.x.size
    updated = False
    while length >= limits.smallest_step:
        call(system.correct, system, here, length, limits, work)
        iterations = work.outcome[0]
        if iterations < 0 and not updated:
            # the tangent of the Jacobian at the solution itself
            copy_to(work.x, here.x)
            p = here.numbers[P]
            call(system.evaluate, system.arrays, here.x, p, work.residual)
            call(system.form_jacobian, system.arrays, here.x, p, work.jacobian)
            copy_to(renewed.arrival, here.tangent)
            for j in range(n):
                renewed.arrival[j] *= size
            renewed.arrival[n] *= scale
            call(system.settle, system, p, size, scale, work, renewed)
            copy_to(here.tangent, renewed.tangent)
            here.numbers[SLOPE] = renewed.numbers[SLOPE]
            updated = True
            continue
        if iterations < 0 and length <= corner_step:
            return -1, length
        if iterations >= 0:
            turn = work.offset[n] * here.arrival[n] / scale
            for j in range(n):
                turn += work.offset[j] * here.arrival[j] / size
            if length <= corner or turn >= 0.0:
                return iterations, length
        length *= 0.5
    return -1, length


@loop
def _with_more_room(
    xs: Matrix, ps: Vector, iterations: NDArray[np.int64], located: NDArray[np.bool_]
) -> tuple[Matrix, Vector, NDArray[np.int64], NDArray[np.bool_]]:
    """The same solutions in arrays of twice the length."""
    size, n = xs.shape
    more, at = np.empty((2 * size, n)), np.empty(2 * size)
    of_more, of_located = np.empty(2 * size, np.int64), np.zeros(2 * size, np.bool_)
    for i in range(size):
        copy_to(more[i], xs[i])
        at[i], of_more[i], of_located[i] = ps[i], iterations[i], located[i]
    return more, at, of_more, of_located


def follow(
    system: System,
    start: Vector,
    window: tuple[float, float],
    limits: Limits,
    at_peak: Limits | None = None,
    falls_to: float = 0.0,
) -> Path:
    """Follow a branch from one end of a window to the other, as ``arc_length.trace``.

    Or to where it has fallen behind a maximum.

    Parameters
    ----------
    system
        The equations.
    start
        Initial guess of the unknown at the first end, shape (n,).
    window
        Parameter where the branch starts and where it ends.
    limits
        Step lengths, tolerances and scales.
    at_peak
        Those with which maxima are located; the same by default.
    falls_to
        Part of the highest located maximum below which the branch is at its end.
    """
    n = start.size
    work, places = make_work(n), (make_place(n) for _ in range(3))
    return _follow(system, start, window, limits, at_peak or limits, falls_to, work, *places)


@kept_loop
def _follow(
    system: System,
    start: Vector,
    window: tuple[float, float],
    limits: Limits,
    at_peak: Limits,
    falls_to: float,
    work: Work,
    here: Place,
    ahead: Place,
    peak: Place,
) -> Path:
    """As ``follow``."""
    n, (begin, end) = start.size, window
    sense = 1.0 if end > begin else -1.0
    xs, ps = np.empty((_ROOM, n)), np.empty(_ROOM)
    iterations, located = np.zeros(_ROOM, np.int64), np.zeros(_ROOM, np.bool_)
    copy_to(work.x, start)
    call(system.solve_at, system, begin, limits, work)
    iterations[0] = work.outcome[0]
    if not work.outcome[1]:
        return Path(xs, ps, iterations, located, 0, False)
    here.arrival[n] = sense
    largest = norm(work.x)
    size, scale = size_of(work.x, largest), scale_at(begin, limits)
    call(system.settle, system, begin, size, scale, work, here)
    here.arrival[n] = 0.0
    ps[0] = begin
    copy_to(xs[0], here.x)
    count = accepted = 1
    length = min(limits.first_step, limits.largest_step)
    orientation = here.numbers[ORIENTATION]
    # of the last two solutions, of the maximum between them, and of the highest one so far
    value = before = here.numbers[VALUE]
    last_highest = highest_of_all = -np.inf
    finished = False
    while not finished and accepted < limits.maximum_solutions:
        step_iterations, length = _advance(system, here, length, limits, work, ahead)
        p = here.numbers[P] + work.offset[n] * here.numbers[SCALE]
        if step_iterations < 0 or (p - begin) * sense < 0:
            break
        for j in range(n):
            ahead.arrival[j] = work.offset[j] * here.numbers[SIZE]
        ahead.arrival[n] = work.offset[n] * here.numbers[SCALE]
        largest = max(largest, norm(work.x))
        size, scale = size_of(work.x, largest), scale_at(p, limits)
        call(system.settle, system, p, size, scale, work, ahead)
        if ahead.numbers[ORIENTATION] * orientation < 0.0:
            break  # the step ends on another part of the branch
        if count + 2 > ps.size:
            xs, ps, iterations, located = _with_more_room(xs, ps, iterations, located)
        highest = -np.inf
        if here.numbers[SLOPE] > 0 and ahead.numbers[SLOPE] <= 0:
            iterations[count] = _locate(system, here, length, at_peak, work, peak)
            if iterations[count] < 0:
                break
            if (peak.numbers[P] - end) * sense < 0:
                ps[count], located[count] = peak.numbers[P], True
                copy_to(xs[count], peak.x)
                highest = peak.numbers[VALUE]
                count += 1
        finished = (p - end) * sense >= 0
        if finished:
            fraction = (end - here.numbers[P]) / (p - here.numbers[P])
            for j in range(n):
                work.x[j] = here.x[j] + fraction * ahead.arrival[j]
            ahead.numbers[P] = end
            call(system.solve_at, system, end, limits, work)
            step_iterations = work.outcome[0]
            if not work.outcome[1]:
                finished = False
                break
            copy_to(ahead.x, work.x)
            call(system.observe, system.arrays, work.x, work.x, ahead.numbers[VALUE:])
        ps[count], iterations[count] = ahead.numbers[P], step_iterations
        copy_to(xs[count], ahead.x)
        count, accepted = count + 1, accepted + 1
        first, before, value = before, value, ahead.numbers[VALUE]
        is_highest = before >= max(first, value) and not first == before == value
        if accepted > 2 and is_highest and max(last_highest, highest) < before:
            finished = False  # a maximum that the slope does not show
            break
        last_highest, highest_of_all = highest, max(highest_of_all, highest)
        finished |= value < falls_to * highest_of_all
        effort = (limits.target_iterations + 1) / (step_iterations + 1)
        length = min(length * min(max(effort, 0.5), 2.0), limits.largest_step)
        here, ahead = ahead, here
    return Path(xs, ps, iterations, located, count, finished)
