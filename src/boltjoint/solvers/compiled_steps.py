"""Newton's method, tangents and corrector of a branch as parts of compiled loops.

They are those of ``solvers.newton`` and ``solvers.corrector``, whose solutions these are to
rounding.
"""

from collections.abc import Callable
from math import sqrt
from typing import NamedTuple

import numpy as np
from numba.extending import get_cython_function_address

from boltjoint.compiled import address_of, call, kept_loop, loop, summing_loop
from boltjoint.solvers.compiled_linear import (
    Matrix,
    Vector,
    Work,
    copy_to,
    make_work,
    norm,
    solve_in_place,
)
from boltjoint.solvers.corrector import SMALLEST_SHARE
from boltjoint.solvers.newton import ROUNDING
from boltjoint.solvers.step_control import StepControl


class Limits(NamedTuple):
    """``StepControl`` as compiled loops take it, and the scales of a system.

    ``residual_scale`` as of ``Equations``. A change of the parameter by ``largest_scale``, or by
    ``relative_scale`` times the parameter if that is less and not negative, counts as much as
    doubling the unknown.
    """

    tolerance: float
    first_step: float
    smallest_step: float
    largest_step: float
    target_iterations: int
    maximum_iterations: int
    smallest_cosine: float
    maximum_solutions: int
    peak_tolerance: float
    residual_scale: float
    largest_scale: float
    relative_scale: float

    @classmethod
    def of(
        cls,
        control: StepControl,
        residual_scale: float,
        largest: float,
        relative: float | None = None,
    ) -> "Limits":
        """The limits of a control; by default the scale of the parameter is the same everywhere."""
        relative = -1.0 if relative is None else relative
        kinds = cls.__annotations__
        return cls(
            # what is compiled is called at its address with numbers of these types
            **{name: kinds[name](getattr(control, name)) for name in cls._fields[:9]},
            residual_scale=float(residual_scale),
            largest_scale=float(largest),
            relative_scale=float(relative),
        )


#: parameter, size of the unknown, scale of the parameter; what is observed, and its slope;
#: orientation of the branch (``Corrector.orientation``), 0 where it is not known
P, SIZE, SCALE, VALUE, SLOPE, ORIENTATION = range(6)


class Place(NamedTuple):
    """A solution from which steps are taken, as ``corrector.Predictor``.

    Attributes
    ----------
    x
        Unknown, shape (n,).
    numbers
        By ``P``, ``SIZE``, ``SCALE``, ``VALUE``, ``SLOPE`` and ``ORIENTATION``: distances are those
        of the unknown over its size, and of the parameter over its scale.
    tangent
        Unit tangent in these distances, shape (n + 1,).
    arrival
        Change of unknown and parameter in the step that ended here, shape (n + 1,).
    """

    x: Vector
    numbers: Vector
    tangent: Vector
    arrival: Vector


def make_place(n: int) -> Place:
    """A place for n unknowns."""
    return Place(np.zeros(n), np.zeros(6), np.zeros(n + 1), np.zeros(n + 1))


class System(NamedTuple):
    """Equations in compiled loops, and the steps of their solution: addresses, and arrays.

    At the addresses are compiled functions (``compiled.call``), so that each is compiled once,
    whatever calls it.

    Attributes
    ----------
    evaluate
        ``(arrays, x, p, residual)`` writes the residual at x and p; what its derivatives need is
        kept in the arrays.
    form_jacobian
        ``(arrays, x, p, jacobian)`` writes the Jacobian where the residual was evaluated last.
    form_parameter_derivative
        ``(arrays, x, p, derivative)`` writes the derivative of the residual by p there.
    observe
        ``(arrays, x, dx, observed)`` writes the quantity whose maxima are located, and its
        derivative in the direction dx or a number of the same sign.
    solve, solve_at, settle, correct
        As ``solve_in_place`` and the functions of these names.
    lapack
        Its ``dgesv``.
    arrays
        A named tuple.
    """

    evaluate: int
    form_jacobian: int
    form_parameter_derivative: int
    observe: int
    solve: int
    solve_at: int
    settle: int
    correct: int
    lapack: int
    arrays: tuple

    @classmethod
    def of(cls, functions: tuple[Callable, ...], arrays: tuple) -> "System":
        """The equations of these four compiled functions, in the order above."""
        key = functions, _types(arrays)
        if key not in _ADDRESSES:
            x, jacobian = np.zeros(0), np.zeros((0, 0))
            examples = (0.0, x), (0.0, jacobian), (0.0, x), (x, x)
            evaluate, form_jacobian, form_parameter_derivative, observe = (
                address_of(function, arrays, x, *example)
                for function, example in zip(functions, examples, strict=True)
            )
            example = cls(0, 0, 0, 0, 0, 0, 0, 0, 0, arrays)
            limits, work, place = Limits.of(StepControl(), 1.0, 1.0), make_work(1), make_place(1)
            _ADDRESSES[key] = cls(
                evaluate=evaluate,
                form_jacobian=form_jacobian,
                form_parameter_derivative=form_parameter_derivative,
                observe=observe,
                solve=address_of(solve_in_place, 0, work, 0),
                solve_at=address_of(solve_at, example, 0.0, limits, work),
                settle=address_of(settle, example, 0.0, 0.0, 0.0, work, place),
                correct=address_of(correct, example, place, 0.0, limits, work),
                lapack=get_cython_function_address("scipy.linalg.cython_lapack", "dgesv"),
                arrays=(),
            )
        return _ADDRESSES[key]._replace(arrays=arrays)


#: by functions and types of arrays
_ADDRESSES: dict[tuple[object, ...], System] = {}


def _types(value: object) -> object:
    """What compiled functions are compiled for, of named tuples of arrays and numbers."""
    if isinstance(value, tuple):
        return type(value), *map(_types, value)
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim, value.flags.carray
    return type(value)


@summing_loop
def _smallest_residual(limits: Limits, x: Vector, jacobian: Matrix) -> float:
    """As ``newton.smallest_residual``."""
    total = 0.0
    for i in range(x.size):
        row = 0.0
        for j in range(x.size):
            row += abs(jacobian[i, j] * x[j])
        total += row * row
    return max(limits.tolerance * limits.residual_scale, ROUNDING * sqrt(total))


@kept_loop
def solve_at(system: System, p: float, limits: Limits, work: Work) -> None:
    """Solve for ``work.x`` at p, as ``newton.newton``; ``work.outcome`` tells how."""
    x, n, size, damping = work.x, work.x.size, np.inf, 1.0
    matrix, correction = work.matrix, work.right
    copy_to(work.trial, x)
    iteration = 0
    while True:
        call(system.evaluate, system.arrays, work.trial, p, work.residual)
        trial_size = norm(work.residual)
        if not trial_size < size and damping > 0.125:
            damping *= 0.5
        else:
            copy_to(x, work.trial)
            size, damping = trial_size, 1.0
            # the limit is that of the last Jacobian
            if iteration == 0:
                call(system.form_jacobian, system.arrays, x, p, work.jacobian)
            converged = size <= _smallest_residual(limits, x, work.jacobian)
            work.outcome[0], work.outcome[1] = iteration, converged
            if converged or iteration == limits.maximum_iterations:
                return
            if iteration > 0:
                call(system.form_jacobian, system.arrays, x, p, work.jacobian)
            for i in range(n):
                correction[i] = work.residual[i]
                for j in range(n):
                    matrix[i, j] = work.jacobian[i, j]
            call(system.solve, system.lapack, work, n)
            if work.sign[0] == 0.0:
                return
            iteration += 1
        for i in range(n):
            work.trial[i] = x[i] - damping * correction[i]


@kept_loop
def settle(
    system: System,
    p: float,
    size: float,
    scale: float,
    work: Work,
    place: Place,
) -> None:
    """Make ``work.x`` a place, with the tangent of ``work.jacobian`` (``Corrector.tangent``).

    The tangent has the sense of the arrival, which the place holds already.
    """
    n, matrix, right, tangent = work.x.size, work.matrix, work.right, place.tangent
    call(system.form_parameter_derivative, system.arrays, work.x, p, work.by_parameter)
    for j in range(n):
        tangent[j] = place.arrival[j] / size
    tangent[n] = place.arrival[n] / scale
    length = norm(tangent)
    for i in range(n):
        for j in range(n):
            matrix[i, j] = work.jacobian[i, j] * size
        matrix[i, n] = work.by_parameter[i] * scale
        size_of_row = norm(matrix[i])
        for j in range(n + 1):
            matrix[i, j] /= size_of_row
        right[i] = 0.0
    for j in range(n + 1):
        matrix[n, j] = tangent[j] / length
    right[n] = 1.0
    call(system.solve, system.lapack, work, n + 1)
    if work.sign[0] != 0.0:
        copy_to(tangent, right)
        length = norm(right)
    for j in range(n + 1):
        tangent[j] /= length
    copy_to(place.x, work.x)
    place.numbers[P], place.numbers[SIZE], place.numbers[SCALE] = p, size, scale
    place.numbers[ORIENTATION] = work.sign[0]
    for j in range(n):
        work.trial[j] = tangent[j] * size
    call(system.observe, system.arrays, place.x, work.trial, place.numbers[VALUE:])


@loop
def size_of(x: Vector, largest: float) -> float:
    """Size of an unknown, in a path with this largest norm."""
    return max(norm(x), SMALLEST_SHARE * largest) or 1.0


@loop
def scale_at(p: float, limits: Limits) -> float:
    """Scale of the parameter."""
    if limits.relative_scale < 0:
        return limits.largest_scale
    return min(limits.largest_scale, limits.relative_scale * abs(p))


@kept_loop
def correct(
    system: System,
    place: Place,
    radius: float,
    limits: Limits,
    work: Work,
) -> None:
    """Solve on a sphere around a place, as ``Corrector.correct``.

    The iterations are ``work.outcome[0]``, -1 if it fails. The solution is ``work.x``, at
    ``work.offset`` from the place, where the residual was evaluated last.
    """
    n, x, offset, matrix, right = work.x.size, work.x, work.offset, work.matrix, work.right
    p, size, scale = place.numbers[P], place.numbers[SIZE], place.numbers[SCALE]
    work.outcome[0] = -1
    for j in range(n + 1):
        offset[j] = radius * place.tangent[j]
    for iteration in range(limits.maximum_iterations + 1):
        for j in range(n):
            x[j] = place.x[j] + offset[j] * size
        at = p + offset[n] * scale
        call(system.evaluate, system.arrays, x, at, work.residual)
        sphere = norm(offset) ** 2 / radius - radius
        # the limit is that of the Jacobian of the last correction
        near = iteration > 0 and abs(sphere) <= 1e-3 * radius
        solved = near and norm(work.residual) <= _smallest_residual(limits, x, work.jacobian)
        if not solved:
            call(system.form_jacobian, system.arrays, x, at, work.jacobian)
        if iteration == 0:
            near = abs(sphere) <= 1e-3 * radius
            solved = near and norm(work.residual) <= _smallest_residual(limits, x, work.jacobian)
        if solved:
            along = 0.0
            for j in range(n + 1):
                along += offset[j] * place.tangent[j]
            if along >= limits.smallest_cosine * radius:
                work.outcome[0] = iteration
            return
        call(system.form_parameter_derivative, system.arrays, x, at, work.by_parameter)
        for i in range(n):
            for j in range(n):
                matrix[i, j] = work.jacobian[i, j] * size
            matrix[i, n] = work.by_parameter[i] * scale
            right[i] = work.residual[i]
        for j in range(n + 1):
            matrix[n, j] = 2.0 * offset[j] / radius
        right[n] = sphere
        call(system.solve, system.lapack, work, n + 1)
        if work.sign[0] == 0.0 or norm(right) > 2.0 * radius:
            return
        for j in range(n + 1):
            offset[j] -= right[j]
