"""The harmonic balance in linear modes as equations of ``solvers.compiled_arc_length``."""

from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import call, kept_loop, loop, summing_loop
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.friction.protocol import Elements, address_of_kernel
from boltjoint.solvers.compiled_steps import System
from boltjoint.solvers.equations import LazyJacobian

Array = NDArray[np.float64]

#: fewer slipping points are projected in loops, more by products of matrices
_FEWEST_POINTS = 16

#: points whose tangents are projected together, so that their products stay in the cache
_POINTS_AT_ONCE = 128


class BalanceArrays(NamedTuple):
    """Arrays of a balance, and those in which the contact is evaluated.

    ``rows``, shape (directions, modes, points), are the modes at the points, which are next to each
    other so that loops over them are vectorised. ``static``, shape (components * modes,) * 2, is
    the linear part at zero frequency, to which ``w^power`` times each of ``varying`` (terms,
    components * modes, components * modes) and ``-(w harmonic)^2`` are added; ``stuck``, of the
    shape of ``static``, the contact's part of the Jacobian while nothing slips, and
    ``stuck_tangent``, shape (points, directions * components), the diagonal of the tangent of each
    point then. ``slipping`` has room for the points with another one; ``column``, ``at_points``,
    ``right`` and ``product`` for what is summed over some points at once. ``add_forces`` is the
    address of the law's kernel. Nonlinear modes need ``coordinates``, ``jacobian``, ``scale``.
    """

    rows: Array
    add_forces: int
    elements: Elements
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
    slipping: NDArray[np.int64]
    column: Array
    at_points: Array
    right: Array
    product: Array
    coordinates: Array
    jacobian: Array
    scale: float


def balance_system(balance: HarmonicBalance) -> System | None:
    """The equations of a balance; None where its law has no kernel."""
    arrays = balance_arrays(balance)
    return None if arrays is None else System.of(_FUNCTIONS, arrays)


def balance_arrays(balance: HarmonicBalance, scale: float = 1.0) -> BalanceArrays | None:
    """The arrays of a balance; None where its law has no kernel."""
    law = balance.joint.law
    if law.kernel is None:
        return None
    add_forces, elements = law.kernel
    rows = np.ascontiguousarray(np.stack([along.T for along in balance.contact.rows]))
    directions, modes, points = rows.shape
    parts = len(balance.components)
    columns = directions * parts
    static, harmonic, power, varying = balance.linear_part()
    n = harmonic.size
    return BalanceArrays(
        rows=rows,
        add_forces=address_of_kernel(add_forces),
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
        slipping=np.zeros(points, np.int64),
        column=np.zeros(_POINTS_AT_ONCE),
        at_points=np.zeros((directions, modes * _POINTS_AT_ONCE)),
        right=np.zeros(parts * parts * modes * _POINTS_AT_ONCE),
        product=np.zeros((modes, parts * parts * modes)),
        coordinates=np.zeros(n),
        jacobian=np.zeros((n, n)),
        scale=scale,
    )


@kept_loop
def evaluate_balance(arrays: BalanceArrays, x: Array, p: float, residual: Array) -> None:
    """Residual at x and the frequency p; forces and tangents of the contact stay in the arrays."""
    motion, force, tangent = arrays.motion, arrays.force, arrays.tangent
    _move(arrays.rows, x, arrays.column, motion)
    force[:] = 0.0
    tangent[:] = 0.0
    call(arrays.add_forces, arrays.elements, motion, force, tangent)
    for i in range(x.size):
        residual[i] = -arrays.excitation[i] - (p * arrays.harmonic[i]) ** 2 * x[i]
    _add_product(1.0, arrays.static, x, residual)
    for k in range(arrays.power.size):
        _add_product(p ** arrays.power[k], arrays.varying[k], x, residual)
    add_modal_force(arrays.rows, force, arrays.column, residual)


@kept_loop
def _evaluate_each(arrays: BalanceArrays, x: Array, p: Array, residuals: Array) -> None:
    """Residuals at several motions and frequencies."""
    for i in range(len(x)):
        evaluate_balance(arrays, x[i], p[i], residuals[i])


@summing_loop
def _add_product(factor: float, matrix: Array, x: Array, target: Array) -> None:
    """Add the product of a matrix and a vector, times a factor."""
    for i in range(target.size):
        total = 0.0
        for j in range(x.size):
            total += matrix[i, j] * x[j]
        target[i] += factor * total


@summing_loop
def _move(rows: Array, x: Array, column: Array, motion: Array) -> None:
    """Motion of the points by the modal coordinates."""
    directions, modes, points = rows.shape
    parts = x.size // modes
    for first in range(0, points, column.size):
        some = min(column.size, points - first)
        for d in range(directions):
            for i in range(parts):
                column[:some] = 0.0
                for m in range(modes):
                    factor = x[i * modes + m]
                    row = rows[d, m, first : first + some]
                    for point in range(some):
                        column[point] += factor * row[point]
                for point in range(some):
                    motion[first + point, d * parts + i] = column[point]


@summing_loop
def add_modal_force(rows: Array, force: Array, column: Array, residual: Array) -> None:
    """Add the forces of the points on the modes."""
    directions, modes, points = rows.shape
    parts = force.shape[1] // directions
    for first in range(0, points, column.size):
        some = min(column.size, points - first)
        for d in range(directions):
            for i in range(parts):
                for point in range(some):
                    column[point] = force[first + point, d * parts + i]
                for m in range(modes):
                    row = rows[d, m, first : first + some]
                    total = 0.0
                    for point in range(some):
                        total += column[point] * row[point]
                    residual[i * modes + m] += total


@kept_loop
def form_jacobian_of_balance(arrays: BalanceArrays, x: Array, p: float, jacobian: Array) -> None:
    """Jacobian at the frequency p from the tangents of the last evaluation."""
    for i in range(x.size):
        for j in range(x.size):
            jacobian[i, j] = arrays.static[i, j] + arrays.stuck[i, j]
        jacobian[i, i] -= (p * arrays.harmonic[i]) ** 2
    for k in range(arrays.power.size):
        factor = p ** arrays.power[k]
        for i in range(x.size):
            for j in range(x.size):
                jacobian[i, j] += factor * arrays.varying[k, i, j]
    for d in range(arrays.rows.shape[0]):
        slipping = arrays.slipping[: _find_slipping(arrays, d)]
        if slipping.size < _FEWEST_POINTS:
            _add_tangents(arrays, slipping, d, jacobian)
        else:
            _add_products(arrays, slipping, d, jacobian)


@loop
def _find_slipping(arrays: BalanceArrays, d: int) -> int:
    """Note the points whose tangent of the force in a direction is not that of sticking contact.

    Their number.
    """
    tangent, stuck = arrays.tangent, arrays.stuck_tangent
    points, columns = stuck.shape
    parts = columns // arrays.rows.shape[0]
    count = 0
    for point in range(points):
        slips = False
        for a in range(d * parts, (d + 1) * parts):
            for b in range(columns):
                slips |= tangent[point, a, b] != (stuck[point, a] if a == b else 0.0)
        if slips:
            arrays.slipping[count] = point
            count += 1
    return count


@loop
def _add_tangents(
    arrays: BalanceArrays, slipping: NDArray[np.int64], d: int, jacobian: Array
) -> None:
    """Add the tangents of the forces in a direction, beyond stick, of these points."""
    rows, tangent, stuck = arrays.rows, arrays.tangent, arrays.stuck_tangent
    directions, modes, _ = rows.shape
    parts = stuck.shape[1] // directions
    for point in slipping:
        for e in range(directions):
            for i in range(parts):
                for j in range(parts):
                    a, b = d * parts + i, e * parts + j
                    t = tangent[point, a, b] - (stuck[point, a] if a == b else 0.0)
                    if t == 0.0:
                        continue
                    for m in range(modes):
                        factor = t * rows[d, m, point]
                        for k in range(modes):
                            jacobian[i * modes + m, j * modes + k] += factor * rows[e, k, point]


@loop
def _add_products(
    arrays: BalanceArrays, slipping: NDArray[np.int64], d: int, jacobian: Array
) -> None:
    """As ``_add_tangents``, by products of matrices.

    The directions of the motion are summed before, as all move by the same coordinates.
    """
    rows, tangent, stuck = arrays.rows, arrays.tangent, arrays.stuck_tangent
    column, product = arrays.column, arrays.product
    directions, modes, _ = rows.shape
    parts = stuck.shape[1] // directions
    for first in range(0, slipping.size, column.size):
        some = slipping[first : first + column.size]
        count = some.size
        right = arrays.right[: parts * parts * modes * count].reshape(-1, count)
        for e in range(directions):
            of_direction = arrays.at_points[e][: modes * count].reshape(modes, count)
            for m in range(modes):
                for s in range(count):
                    of_direction[m, s] = rows[e, m, some[s]]
        for i in range(parts):
            for j in range(parts):
                for e in range(directions):
                    a, b = d * parts + i, e * parts + j
                    none = True
                    for s in range(count):
                        at_stick = stuck[some[s], a] if a == b else 0.0
                        column[s] = tangent[some[s], a, b] - at_stick
                        none &= column[s] == 0.0
                    if e > 0 and none:  # tangential motion never changes the normal force
                        continue
                    of_direction = arrays.at_points[e][: modes * count].reshape(modes, count)
                    for k in range(modes):
                        row = (i * parts + j) * modes + k
                        if e == 0:
                            for s in range(count):
                                right[row, s] = column[s] * of_direction[k, s]
                        else:
                            for s in range(count):
                                right[row, s] += column[s] * of_direction[k, s]
        left = arrays.at_points[d][: modes * count].reshape(modes, count)
        np.dot(left, right.T, product)
        for m in range(modes):
            for i in range(parts):
                for j in range(parts):
                    begin = (i * parts + j) * modes
                    for k in range(modes):
                        jacobian[i * modes + m, j * modes + k] += product[m, begin + k]


@kept_loop
def _form_parameter_derivative(
    arrays: BalanceArrays, x: Array, p: float, derivative: Array
) -> None:
    """Derivative of the residual by the frequency p."""
    for i in range(x.size):
        derivative[i] = -2.0 * p * arrays.harmonic[i] ** 2 * x[i]
    for k in range(arrays.power.size):
        factor = arrays.power[k] * p ** (arrays.power[k] - 1.0)
        _add_product(factor, arrays.varying[k], x, derivative)


@kept_loop
def _observe(arrays: BalanceArrays, x: Array, dx: Array, observed: Array) -> None:
    """Amplitude of the output point [m], and half the slope of its square."""
    modes = arrays.response.size
    s, c, ds, dc = 0.0, 0.0, 0.0, 0.0
    sin, cos = x.size - 2 * modes, x.size - modes
    for m in range(modes):
        s += arrays.response[m] * x[sin + m]
        c += arrays.response[m] * x[cos + m]
        ds += arrays.response[m] * dx[sin + m]
        dc += arrays.response[m] * dx[cos + m]
    observed[0], observed[1] = hypot(s, c), s * ds + c * dc


_FUNCTIONS = evaluate_balance, form_jacobian_of_balance, _form_parameter_derivative, _observe


class CompiledBalance:
    """A balance, evaluated one by one by its compiled functions.

    Parameters
    ----------
    arrays
        Of the balance; evaluations write into them.
    """

    def __init__(self, arrays: BalanceArrays) -> None:
        self._arrays = arrays

    @classmethod
    def of(cls, balance: HarmonicBalance) -> "CompiledBalance | None":
        """That of a balance; None where its law has no kernel."""
        arrays = balance_arrays(balance)
        return None if arrays is None else cls(arrays)

    def residuals(self, x: Array, w: Array) -> Array:
        """Residuals at x (motions, unknowns) and w (motions,) [rad/s], of the shape of x."""
        residuals = np.empty_like(x)
        _evaluate_each(self._arrays, x, w, residuals)
        return residuals

    def residual_and_jacobian(self, x: Array, w: float) -> tuple[Array, LazyJacobian]:
        """As of the balance; the Jacobian can be formed until the next evaluation."""
        residual = np.empty(x.size)
        evaluate_balance(self._arrays, x, w, residual)

        def jacobian() -> Array:
            matrix = np.empty((x.size, x.size))
            form_jacobian_of_balance(self._arrays, x, w, matrix)
            return matrix

        return residual, jacobian
