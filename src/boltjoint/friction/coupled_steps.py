"""A straight step of a slider in the plane with a circular limit of its friction, and its tangent.

Here x and y are along the first and the second tangent of a contact point.

Between two samples displacement x and slip limit r change linearly. The friction f sticks
(``f' = x'``) until it meets the limit, and from there on has its magnitude r and the direction of
the slip, ``x' - f' = l f``. With the angle a from the direction of x' to f this is ``a' = - |x'|
sin(a) / r``, whose solution is a tractrix::

    tan(a_2 / 2) = tan(a_1 / 2) exp(- |x_2 - x_1| log(r_2 / r_1) / (r_2 - r_1))

So a step is exact where the path is straight: what is left is the error of the chord, of second
order, where the radial return of plasticity (a step to the nearest point of the limit) has one of
first order in the direction. On a straight orbit both are the one-directional law.

References
----------
R. D. Krieg, D. B. Krieg: Accuracies of numerical solution methods for the elastic-perfectly plastic
model. Journal of Pressure Vessel Technology 99 (1977) 510-515: the exact solution for straight
paths, of a constant limit.
"""

from math import exp, inf, log1p, sqrt

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import loop

Array = NDArray[np.float64]

#: relative distance from the limit within which friction has reached it before, but for rounding
_AT_LIMIT = 1e-12

#: relative change of the limit below which series replace differences
_SMALL = 1e-5

#: columns of a derivative of the friction: by x and y of friction and displacement before the step,
#: and by the limit at both of its ends
F, D, BEFORE, AFTER = 0, 2, 4, 5


@loop
def length_of(x: float, y: float) -> float:
    """Length of a vector; ``hypot``, which cannot overflow, takes longer."""
    return sqrt(x * x + y * y)


@loop
def slip_along(
    f: tuple[float, float],
    before: float,
    step: tuple[float, float],
    after: float,
    derivative: Array,
) -> tuple[float, float]:
    """Friction after a straight step at whose end it cannot stick any more.

    Parameters
    ----------
    f, step
        Friction before the step, and the change of the spring force in stick, along x and y.
    before, after
        Limit of the friction at both ends of the step; the last is positive.
    derivative
        Filled with the derivatives of the friction, shape (2, 6), unless it is empty.
    """
    (f_x, f_y), (d_x, d_y) = f, step
    length, growth = length_of(d_x, d_y), after - before
    # in stick up to the part s of the step: |f + s d| = before + s growth
    a = length * length - growth * growth
    b = f_x * d_x + f_y * d_y - before * growth
    c = min(f_x * f_x + f_y * f_y - before * before, 0.0)
    at_limit = b > 0.0 and -c <= _AT_LIMIT * before * before
    if at_limit:
        s = 0.0
    else:
        root = sqrt(max(b * b - a * c, 0.0))
        s = -c / (b + root) if b > 0.0 else (root - b) / a
        s = min(max(s, 0.0), 1.0)
    limit = before + s * growth
    e_x, e_y = f_x + s * d_x, f_y + s * d_y
    size = length_of(e_x, e_y)
    if limit <= 0.0 or size == 0.0:  # closing: friction begins along the motion
        limit, e_x, e_y = 0.0, d_x / length, d_y / length
    else:
        e_x, e_y = e_x / size, e_y / size
    u_x, u_y = (d_x / length, d_y / length) if length > 0.0 else (e_x, e_y)
    cosine, sine = e_x * u_x + e_y * u_y, u_x * e_y - u_y * e_x
    # 1 + cosine and 1 - cosine without cancellation
    plus = 1.0 + cosine if cosine > 0.0 else sine * sine / (1.0 - cosine)
    minus = 1.0 - cosine if cosine < 0.0 else sine * sine / (1.0 + cosine)
    change = (after - limit) / limit if limit > 0.0 else inf
    if limit == 0.0:
        rate, w = 0.0, 0.0
    else:
        rate = (log1p(change) / change if change != 0.0 else 1.0) / limit
        w = exp(-(1.0 - s) * length * rate)
    whole = plus + minus * w * w
    new_cosine, ratio = (plus - minus * w * w) / whole, 2.0 * w / whole
    new_sine = ratio * sine
    g_x, g_y = new_cosine * u_x - new_sine * u_y, new_cosine * u_y + new_sine * u_x
    if derivative.size:
        # by rows of ds, the part in stick
        derivative[:] = 0.0
        ds, turn = derivative[0], derivative[1]
        approach = e_x * d_x + e_y * d_y - growth
        if not at_limit and limit > 0.0 and approach > 0.0:
            ds[F], ds[F + 1] = -e_x / approach, -e_y / approach
            ds[D], ds[D + 1] = -s * e_x / approach, -s * e_y / approach
            ds[BEFORE], ds[AFTER] = (1.0 - s) / approach, s / approach
        across = -e_y * d_x + e_x * d_y
        if abs(change) < _SMALL:
            by_after = (-0.5 + 2.0 / 3.0 * change) / (limit * limit)
            by_limit = (-0.5 - 2.0 / 3.0 * change) / (after * after)
        else:
            by_after = (1.0 / after - rate) / (after - limit)
            by_limit = (rate - 1.0 / limit) / (after - limit)
        # of the direction of the motion, and its weight over the length of the step
        if limit == 0.0:
            share = 1.0 / length
        else:
            way = (1.0 - w) / length if length > 0.0 else (1.0 - s) * rate
            share = way * (2.0 - minus * (1.0 + w)) / whole
        for j in range(6):
            of_s = ds[j]
            of_f_x, of_f_y = (1.0 if j == F else 0.0), (1.0 if j == F + 1 else 0.0)
            of_d_x, of_d_y = (1.0 if j == D else 0.0), (1.0 if j == D + 1 else 0.0)
            of_after = 1.0 if j == AFTER else 0.0
            turned = share * (u_x * of_d_y - u_y * of_d_x)
            if limit > 0.0:
                of_before = 1.0 if j == BEFORE else 0.0
                of_limit = (1.0 - s) * of_before + s * of_after + growth * of_s
                moved_x, moved_y = of_f_x + s * of_d_x, of_f_y + s * of_d_y
                swung = (e_x * moved_y - e_y * moved_x + across * of_s) / limit
                decay = rate * ((1.0 - s) * (u_x * of_d_x + u_y * of_d_y) - length * of_s)
                decay += (1.0 - s) * length * (by_limit * of_limit + by_after * of_after)
                turned += ratio * swung - new_sine * decay
            ds[j], turn[j] = of_after, turned
        for j in range(6):
            along, turned = ds[j], after * turn[j]
            derivative[0, j] = along * g_x - turned * g_y
            derivative[1, j] = along * g_y + turned * g_x
    return after * g_x, after * g_y
