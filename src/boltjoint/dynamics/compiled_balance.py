"""The harmonic balance in linear modes as a system of ``solvers.compiled_path``."""

from math import hypot
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from boltjoint.compiled import implements, loop
from boltjoint.dynamics.harmonic_balance import HarmonicBalance
from boltjoint.friction.kernels import add_forces
from boltjoint.solvers import compiled_steps

Array = NDArray[np.float64]

#: fewer points are projected in loops, more by products of matrices
_FEWEST_POINTS = 16

#: points whose tangents are projected together, so that their products stay in the cache
_POINTS_AT_ONCE = 128


class BalanceSystem(NamedTuple):
    """Arrays of a balance, and those in which the contact is evaluated.

    ``static``, shape (components * modes,) * 2, is the linear part at zero frequency, to which
    ``w^power`` times each of ``varying`` (terms, components * modes, components * modes) and ``-(w
    harmonic)^2`` are added. ``stuck`` is the contact's part of the Jacobian while nothing slips,
    and ``stuck_tangent``, shape (points, directions * components), the diagonal of the tangent of
    each point then.
    """

    rows: Array
    elements: tuple
    static: Array
    harmonic: Array
    power: Array
    varying: Array
    stuck: Array
    stuck_tangent: Array
    excitation: Array
    response: Array
    motion: Array
    force: Array
    tangent: Array


def balance_system(balance: HarmonicBalance) -> BalanceSystem | None:
    """The system of a balance; None where its law has no compiled forces."""
    elements = balance.joint.law.compiled_elements
    if elements is None:
        return None
    rows = np.ascontiguousarray(np.stack(balance.contact.rows))
    directions, points, _ = rows.shape
    columns = directions * len(balance.components)
    static, harmonic, power, varying = balance.linear_part()
    return BalanceSystem(
        rows=rows,
        elements=elements,
        static=static,
        harmonic=harmonic,
        power=power,
        varying=varying,
        stuck=balance.contact.stuck_stiffness,
        stuck_tangent=balance.contact.stuck_tangents,
        excitation=balance.modal_force,
        response=np.ascontiguousarray(balance.joint.response_mode),
        motion=np.zeros((points, columns)),
        force=np.zeros((points, columns)),
        tangent=np.zeros((points, columns, columns)),
    )


@implements(compiled_steps.evaluate, of=BalanceSystem)
@loop
def _evaluate(system: BalanceSystem, x: Array, p: float, residual: Array) -> None:
    """Residual at x and the frequency p; forces and tangents of the contact stay in the system."""
    motion, force, tangent = system.motion, system.force, system.tangent
    _move(system.rows, x, motion)
    force[:] = 0.0
    tangent[:] = 0.0
    add_forces(system.elements, motion, force, tangent)
    n = x.size
    for i in range(n):
        total = -system.excitation[i] - (p * system.harmonic[i]) ** 2 * x[i]
        for j in range(n):
            total += system.static[i, j] * x[j]
        residual[i] = total
    for k in range(system.power.size):
        factor = p ** system.power[k]
        for i in range(n):
            for j in range(n):
                residual[i] += factor * system.varying[k, i, j] * x[j]
    _add_modal_force(system.rows, force, residual)


@njit(error_model="numpy", fastmath={"reassoc", "contract"})
def _move(rows: Array, x: Array, motion: Array) -> None:
    """Motion of the points by the modal coordinates."""
    directions, points, modes = rows.shape
    parts = x.size // modes
    for point in range(points):
        for d in range(directions):
            for i in range(parts):
                total = 0.0
                for m in range(modes):
                    total += rows[d, point, m] * x[i * modes + m]
                motion[point, d * parts + i] = total


@njit(error_model="numpy", fastmath={"reassoc", "contract"})
def _add_modal_force(rows: Array, force: Array, residual: Array) -> None:
    """Add the forces of the points on the modes."""
    directions, points, modes = rows.shape
    parts = residual.size // modes
    for point in range(points):
        for d in range(directions):
            for i in range(parts):
                f = force[point, d * parts + i]
                for m in range(modes):
                    residual[i * modes + m] += f * rows[d, point, m]


@implements(compiled_steps.form_jacobian, of=BalanceSystem)
@loop
def _form_jacobian(system: BalanceSystem, x: Array, p: float, jacobian: Array) -> None:
    """Jacobian at the frequency p from the tangents of the last evaluation."""
    for i in range(x.size):
        for j in range(x.size):
            jacobian[i, j] = system.static[i, j] + system.stuck[i, j]
        jacobian[i, i] -= (p * system.harmonic[i]) ** 2
    for k in range(system.power.size):
        factor = p ** system.power[k]
        for i in range(x.size):
            for j in range(x.size):
                jacobian[i, j] += factor * system.varying[k, i, j]
    if system.rows.shape[1] < _FEWEST_POINTS:
        _add_tangents(system, jacobian)
    else:
        _add_products(system, jacobian)


@loop
def _sticks(system: BalanceSystem, point: int) -> bool:
    """Whether the tangent of a point is that of sticking contact."""
    tangent, stuck = system.tangent[point], system.stuck_tangent[point]
    for i in range(stuck.size):
        for j in range(stuck.size):
            if tangent[i, j] != (stuck[i] if i == j else 0.0):
                return False
    return True


@loop
def _add_tangents(system: BalanceSystem, jacobian: Array) -> None:
    """Add the tangents, beyond those of sticking contact, of all points."""
    rows, tangent, stuck = system.rows, system.tangent, system.stuck_tangent
    directions, points, modes = rows.shape
    parts = stuck.shape[1] // directions
    for point in range(points):
        if _sticks(system, point):
            continue
        for d in range(directions):
            for e in range(directions):
                for m in range(modes):
                    for k in range(modes):
                        product = rows[d, point, m] * rows[e, point, k]
                        for i in range(parts):
                            for j in range(parts):
                                a, b = d * parts + i, e * parts + j
                                t = tangent[point, a, b] - (stuck[point, a] if a == b else 0.0)
                                jacobian[i * modes + m, j * modes + k] += t * product


@loop
def _add_products(system: BalanceSystem, jacobian: Array) -> None:
    """As ``_add_tangents``, by products of matrices."""
    rows, tangent, stuck = system.rows, system.tangent, system.stuck_tangent
    directions, points, modes = rows.shape
    parts = stuck.shape[1] // directions
    slipping = np.empty(points, np.int64)
    count = 0
    for point in range(points):
        if not _sticks(system, point):
            slipping[count] = point
            count += 1
    left = np.zeros((_POINTS_AT_ONCE, modes))
    right = np.zeros((_POINTS_AT_ONCE, parts * parts * modes))
    found = np.empty((modes, parts * parts * modes))
    for d in range(directions):
        for e in range(directions):
            for first in range(0, count, _POINTS_AT_ONCE):
                size = min(_POINTS_AT_ONCE, count - first)
                for row in range(size):
                    point = slipping[first + row]
                    left[row] = rows[d, point]
                    for i in range(parts):
                        for j in range(parts):
                            a, b = d * parts + i, e * parts + j
                            t = tangent[point, a, b] - (stuck[point, a] if a == b else 0.0)
                            begin = (i * parts + j) * modes
                            for k in range(modes):
                                right[row, begin + k] = t * rows[e, point, k]
                np.dot(left[:size].T, right[:size], found)
                for m in range(modes):
                    for i in range(parts):
                        for j in range(parts):
                            begin = (i * parts + j) * modes
                            for k in range(modes):
                                jacobian[i * modes + m, j * modes + k] += found[m, begin + k]


@implements(compiled_steps.form_parameter_derivative, of=BalanceSystem)
@loop
def _form_parameter_derivative(
    system: BalanceSystem, x: Array, p: float, derivative: Array
) -> None:
    """Derivative of the residual by the frequency p."""
    for i in range(x.size):
        derivative[i] = -2.0 * p * system.harmonic[i] ** 2 * x[i]
    for k in range(system.power.size):
        factor = system.power[k] * p ** (system.power[k] - 1.0)
        for i in range(x.size):
            for j in range(x.size):
                derivative[i] += factor * system.varying[k, i, j] * x[j]


@loop
def _output(system: BalanceSystem, x: Array) -> tuple[float, float]:
    """Sine and cosine coefficient of the output point, of the first harmonic."""
    modes = system.response.size
    s, c = 0.0, 0.0
    start = x.size - 2 * modes
    for m in range(modes):
        s += system.response[m] * x[start + m]
        c += system.response[m] * x[start + modes + m]
    return s, c


@implements(compiled_steps.observe, of=BalanceSystem)
@loop
def _observe(system: BalanceSystem, x: Array) -> float:
    """Amplitude of the output point [m]."""
    s, c = _output(system, x)
    return hypot(s, c)


@implements(compiled_steps.observe_slope, of=BalanceSystem)
@loop
def _observe_slope(system: BalanceSystem, x: Array, dx: Array) -> float:
    """Half the derivative of its square."""
    (s, c), (ds, dc) = _output(system, x), _output(system, dx)
    return s * ds + c * dc
