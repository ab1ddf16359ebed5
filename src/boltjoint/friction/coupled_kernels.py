"""Compiled loops of coupled friction: sliders in the plane, followed through samples of a period.

The forces are those of a period in which a slider returns to where it began: the second from the
assembled state on straight orbits. Where it slips little on each, friction turns slowly (on narrow
orbits by 4e-4 of what is left a period), and that period is found by Newton's method. The forces'
derivatives are those of that period, in which the slider begins where the motion makes it periodic.
"""

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop, loop
from boltjoint.friction.coupled_steps import AFTER, BEFORE, D, F, length_of, slip_along

Array = NDArray[np.float64]

#: change of a slider over a period below which it is periodic, relative to the largest limit and,
#: for rounding, to the largest spring force
_RETURN, _ROUNDING = 1e-11, 1e-15

#: periods that are followed before a periodic one is sought, most sliders being periodic by then
_FOLLOWED = 2

#: corrections of Newton's method, of which narrow orbits need six
_MOST_CORRECTIONS = 12

#: periods after which a slider counts as periodic: only within 1e-6 of the amplitude at which it
#: begins to slip on a circular orbit does it move after that, by less than 1e-3 of the limit
_MOST_PERIODS = 1000

#: determinant of I - M below which a slider keeps what it had before, M being the derivative of its
#: position after a period by that before
_SINGULAR = 1e-6


@loop
def _start(
    x: Array, limit: Array, motion_at: tuple[Array, Array, Array], z: Array, by_motion: Array
) -> None:
    """Set the slider at the last sample, after a straight motion from the assembled state."""
    of_x, of_y, of_limit = motion_at
    r, size = limit[-1], length_of(x[0, -1], x[1, -1])
    z[:] = 0.0
    by_motion[:] = 0.0
    if size <= r:
        return
    e_x, e_y = x[0, -1] / size, x[1, -1] / size
    z[0], z[1] = x[0, -1] - r * e_x, x[1, -1] - r * e_y
    for c in range(by_motion.shape[1]):
        turned = (1.0 - r / size) * (e_x * of_y[c] - e_y * of_x[c])
        along = e_x * of_x[c] + e_y * of_y[c] - of_limit[c]
        by_motion[0, c] = along * e_x - turned * e_y
        by_motion[1, c] = along * e_y + turned * e_x


@loop
def _derive_step(
    derivative: Array,
    now: tuple[Array, Array, Array],
    last: tuple[Array, Array, Array],
    closing: tuple[float, float, float, float, float],
    is_closing: bool,
    slips: bool,
    by_motion: Array,
) -> None:
    """Derivative of the slider by the motion after a step, from that before it.

    ``now`` and ``last`` are the derivatives of x, y and the limit at both samples; ``closing`` is
    the part of the step before the contact closes, its derivatives by the limits at both ends as if
    they could be negative, and the step.
    """
    part, by_last, by_now, d_x, d_y = closing
    for c in range(by_motion.shape[1]):
        if is_closing:
            of_part = by_last * last[2][c] + by_now * now[2][c]
            z_x = last[0][c] + part * (now[0][c] - last[0][c]) + d_x * of_part
            z_y = last[1][c] + part * (now[1][c] - last[1][c]) + d_y * of_part
            f_x = f_y = before = 0.0
            s_x, s_y = now[0][c] - z_x, now[1][c] - z_y
        else:
            z_x, z_y = by_motion[0, c], by_motion[1, c]
            f_x, f_y, before = last[0][c] - z_x, last[1][c] - z_y, last[2][c]
            s_x, s_y = now[0][c] - last[0][c], now[1][c] - last[1][c]
        if slips:
            for i in range(2):
                row = derivative[i]
                of_f = row[F] * f_x + row[F + 1] * f_y + row[D] * s_x + row[D + 1] * s_y
                of_f += row[BEFORE] * before + row[AFTER] * now[2][c]
                by_motion[i, c] = now[i][c] - of_f
        else:
            by_motion[0, c], by_motion[1, c] = z_x, z_y


@loop
def _follow_period(
    loading: tuple[Array, Array, Array],
    of_motion: tuple[Array, Array, Array],
    smallest: float,
    z: Array,
    by_motion: Array,
    derivative: Array,
    friction: Array,
    slope: Array,
) -> bool:
    """Move a slider through a period of samples; whether it slips, by more than the smallest slip.

    ``loading`` is the spring force with the slider at rest, the normal load and the limit,
    ``of_motion`` the derivatives of the force in the plane and of the limit. ``slope`` is filled
    with derivatives of the friction by the motion, shape (samples, 2, columns), and ``by_motion``
    with that of the slider, if ``derivative`` is not empty.
    """
    x, n, limit = loading
    samples = x.shape[1]
    slips_at_all = False
    for i in range(samples):
        last = i - 1 if i else samples - 1
        now_at = of_motion[0][i], of_motion[1][i], of_motion[2][i]
        last_at = of_motion[0][last], of_motion[1][last], of_motion[2][last]
        if n[i] <= 0.0:
            z[0], z[1] = x[0, i], x[1, i]
            friction[0, i] = friction[1, i] = 0.0
            if derivative.size:
                by_motion[0], by_motion[1] = now_at[0], now_at[1]
                slope[i] = 0.0
            continue
        d_x, d_y = x[0, i] - x[0, last], x[1, i] - x[1, last]
        before, is_closing = limit[last], n[last] <= 0.0
        closing = 0.0, 0.0, 0.0, d_x, d_y
        if is_closing:
            # where n rises through zero, by linear interpolation between the samples
            span = n[i] - n[last]
            part, scale = -n[last] / span, (limit[i] / n[i]) if n[i] > 0.0 else 1.0
            closing = part, -n[i] / (span * span * scale), n[last] / (span * span * scale), d_x, d_y
            z[0], z[1] = x[0, last] + part * d_x, x[1, last] + part * d_y
            d_x, d_y, before = x[0, i] - z[0], x[1, i] - z[1], 0.0
        f_x, f_y = x[0, i] - z[0], x[1, i] - z[1]
        excess = length_of(f_x, f_y) - limit[i]
        slips = excess > 0.0
        slips_at_all |= excess > smallest
        if slips:
            f = f_x - d_x, f_y - d_y
            f_x, f_y = slip_along(f, before, (d_x, d_y), limit[i], derivative)
            z[0], z[1] = x[0, i] - f_x, x[1, i] - f_y
        friction[0, i], friction[1, i] = x[0, i] - z[0], x[1, i] - z[1]
        if derivative.size:
            if slips or is_closing:
                _derive_step(derivative, now_at, last_at, closing, is_closing, slips, by_motion)
            slope[i, 0], slope[i, 1] = now_at[0] - by_motion[0], now_at[1] - by_motion[1]
    return slips_at_all


@loop
def _inverse(by_begin: Array) -> tuple[float, float, float, float, bool]:
    """Inverse of I - M by rows, and whether there is one, M being the derivative over a period."""
    a, b, c, d = 1.0 - by_begin[0, 0], -by_begin[0, 1], -by_begin[1, 0], 1.0 - by_begin[1, 1]
    determinant = a * d - b * c
    if abs(determinant) <= _SINGULAR:
        return 0.0, 0.0, 0.0, 0.0, False
    return d / determinant, -b / determinant, -c / determinant, a / determinant, True


@loop
def _find_periodic(loading: tuple[Array, Array, Array], smallest: float, now: Array) -> None:
    """Set ``now`` to where a slider is periodic, sought from there by Newton's method, if found.

    Periods bring two positions of a slider never further apart, so that one that is periodic by
    itself is the one in which following periods would end.
    """
    samples = loading[0].shape[1]
    at_rest, slope = np.zeros((samples, 2)), np.empty((samples, 2, 2))
    of_motion = at_rest, at_rest, at_rest
    derivative, friction = np.empty((2, 6)), np.empty((2, samples))
    begin, end, by_begin = now.copy(), np.empty(2), np.empty((2, 2))
    for _ in range(_MOST_CORRECTIONS):
        end[:], by_begin[:] = begin, np.eye(2)
        _follow_period(loading, of_motion, smallest, end, by_begin, derivative, friction, slope)
        g_x, g_y = end[0] - begin[0], end[1] - begin[1]
        if length_of(g_x, g_y) <= smallest:
            now[:] = end
            return
        a, b, c, d, is_single = _inverse(by_begin)
        if not is_single:
            return
        begin[0] += a * g_x + b * g_y
        begin[1] += c * g_x + d * g_y


@loop
def _follow_until_periodic(
    loading: tuple[Array, Array, Array],
    of_motion: tuple[Array, Array, Array],
    z: Array,
    by_motion: Array,
    derivative: Array,
    friction: Array,
    slope: Array,
) -> bool:
    """Follow a slider from the assembled state until it is periodic; whether it slips then.

    As ``_follow_period``; z is set to the position at the begin of the last period. With
    derivatives all periods are followed, without some are passed over.
    """
    x, _, limit = loading
    now = np.empty(2)
    last = of_motion[0][-1], of_motion[1][-1], of_motion[2][-1]
    _start(x, limit, last, now, by_motion)
    smallest = max(_RETURN * limit.max(), _ROUNDING * np.abs(x).max())
    attempt = _FOLLOWED if derivative.size == 0 else _MOST_PERIODS
    for period in range(_MOST_PERIODS):
        z[:] = now
        slips = _follow_period(
            loading, of_motion, smallest, now, by_motion, derivative, friction, slope
        )
        if length_of(now[0] - z[0], now[1] - z[1]) <= smallest:
            break
        if period == attempt:
            # where it fails, it is tried again after twice as many periods
            _find_periodic(loading, smallest, now)
            attempt *= 2
    return slips


@loop
def _differentiate(
    loading: tuple[Array, Array, Array],
    of_motion: tuple[Array, Array, Array],
    z: Array,
    by_motion: Array,
    derivative: Array,
    friction: Array,
    slope: Array,
) -> None:
    """Derivatives of the friction in the period of a slider that begins at z: the slope.

    The last two columns are those by z itself, which moves with the motion so that it is periodic:
    ``dz = M dz + G``. A slider that keeps what it had before is followed from the assembled state.
    """
    by_motion[:] = 0.0
    by_motion[0, -2] = by_motion[1, -1] = 1.0
    begin = z.copy()
    _follow_period(loading, of_motion, 0.0, begin, by_motion, derivative, friction, slope)
    a, b, c, d, is_single = _inverse(by_motion[:, -2:])
    if not is_single:
        _follow_until_periodic(loading, of_motion, begin, by_motion, derivative, friction, slope)
        return
    for column in range(by_motion.shape[1] - 2):
        g_x, g_y = by_motion[0, column], by_motion[1, column]
        z_x, z_y = a * g_x + b * g_y, c * g_x + d * g_y
        for i in range(len(slope)):
            slope[i, 0, column] += slope[i, 0, -2] * z_x + slope[i, 0, -1] * z_y
            slope[i, 1, column] += slope[i, 1, -2] * z_x + slope[i, 1, -1] * z_y


@loop
def _set_element(
    quantities: Array, e: int, displacement: Array, x: Array, n: Array, limit: Array
) -> None:
    """Spring forces, normal load and limit of an element at the samples, by its point's motion."""
    k_u, k_v, load, mu = quantities[0, e], quantities[1, e], quantities[2, e], quantities[3, e]
    for i in range(n.size):
        x[0, i], x[1, i] = k_u * displacement[0, i], k_u * displacement[1, i]
        n[i] = load
        if len(displacement) > 2:
            n[i] += k_v * displacement[2, i]
        limit[i] = mu * max(n[i], 0.0)


@kept_loop
def add_forces(
    point_of_element: NDArray[np.int64],
    quantities: Array,
    motion: Array,
    synthesis: Array,
    force: Array,
    tangent: Array,
) -> None:
    """Add sums of the forces over the samples, times each component, and harmonic tangents.

    Parameters
    ----------
    point_of_element
        Contact point of each element, shape (elements,).
    quantities
        k_u, k_v, n0 and mu of each, shape (4, elements).
    motion, force, tangent
        As of ``FrictionLaw``, with any number of harmonics; the tangent may be empty. It is by sums
        over the samples, too.
    synthesis
        Values of the components at the samples, shape (components, samples).
    """
    count, samples = synthesis.shape
    columns = motion.shape[1]
    directions = columns // count
    at_samples = np.ascontiguousarray(synthesis.T)
    displacement = np.empty((directions, samples))
    x, n, limit = np.empty((2, samples)), np.empty(samples), np.empty(samples)
    friction, load = np.empty((2, samples)), np.empty(samples)
    none, derivative = np.empty((0, 6)), np.empty((2, 6))
    z, by_motion = np.empty(2), np.zeros((2, columns + 2))
    slope = np.zeros((samples, 2, columns + 2))
    of_x, of_y = np.zeros((samples, columns + 2)), np.zeros((samples, columns + 2))
    of_limit = np.zeros((samples, columns + 2))
    contact = np.empty((samples, count))
    for e in range(point_of_element.size):
        p = point_of_element[e]
        k_u, k_v, mu = quantities[0, e], quantities[1, e], quantities[3, e]
        for d in range(directions):
            np.dot(motion[p, d * count : (d + 1) * count], synthesis, displacement[d])
        _set_element(quantities, e, displacement, x, n, limit)
        loading, of_motion = (x, n, limit), (of_x, of_y, of_limit)
        # first without derivatives, which an element in stick does not need
        slips = _follow_until_periodic(loading, of_motion, z, by_motion, none, friction, slope)
        assembled = max(quantities[2, e], 0.0)
        for i in range(samples):
            load[i] = max(n[i], 0.0) - assembled
        for d in range(directions):
            values = friction[d] if d < 2 else load
            for c in range(count):
                total = 0.0
                for i in range(samples):
                    total += values[i] * synthesis[c, i]
                force[p, d * count + c] += total
        if tangent.size == 0:
            continue
        moved = False
        for i in range(samples):
            # a slider that once slipped has a derivative even where it sticks
            moved |= friction[0, i] != x[0, i] or friction[1, i] != x[1, i]
        if slips or moved:
            of_x[:, :count], of_y[:, count : 2 * count] = k_u * at_samples, k_u * at_samples
            if directions > 2:
                for i in range(samples):
                    closed = mu * k_v
                    for c in range(count):
                        of_limit[i, 2 * count + c] = closed * at_samples[i, c]
            _differentiate(loading, of_motion, z, by_motion, derivative, friction, slope)
            for d in range(2):
                of_direction = np.ascontiguousarray(slope[:, d, :columns])
                tangent[p, d * count : (d + 1) * count] += np.dot(synthesis, of_direction)
        else:
            products = k_u * np.dot(synthesis, at_samples)
            for d in range(2):
                at = slice(d * count, (d + 1) * count)
                tangent[p, at, at] += products
        if directions > 2:
            for i in range(samples):
                contact[i] = k_v * at_samples[i] if n[i] > 0.0 else 0.0 * at_samples[i]
            tangent[p, 2 * count :, 2 * count :] += np.dot(synthesis, contact)


@kept_loop
def find_slip(
    point_of_element: NDArray[np.int64],
    quantities: Array,
    displacement: Array,
    slips: NDArray[np.bool_],
    load: Array,
) -> None:
    """Fill in whether each element slips in the steady state, and its normal load at samples.

    ``displacement`` is that of the points, shape (points, directions, samples).
    """
    samples = displacement.shape[2]
    x, limit, friction = np.empty((2, samples)), np.empty(samples), np.empty((2, samples))
    z, by_motion, none = np.empty(2), np.zeros((2, 1)), np.empty((0, 6))
    slope, unused = np.zeros((1, 2, 1)), np.zeros((samples, 1))
    for e in range(point_of_element.size):
        _set_element(quantities, e, displacement[point_of_element[e]], x, load[e], limit)
        loading, of_motion = (x, load[e], limit), (unused, unused, unused)
        slips[e] = _follow_until_periodic(loading, of_motion, z, by_motion, none, friction, slope)
