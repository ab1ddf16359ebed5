"""Friction of springs with sliders, integrated in time along a harmonic motion of their points.

No code is shared with the describing functions of the laws, so that either verifies the other.
"""

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop

#: elements integrated side by side: many for the processor's vectors, few for its cache
_LANES = 128


def integrate_friction(
    point: NDArray[np.int64],
    tangential_stiffness: NDArray[np.float64],
    normal_stiffness: NDArray[np.float64] | None,
    normal_load: NDArray[np.float64],
    friction_coefficient: NDArray[np.float64],
    motion: NDArray[np.float64],
    samples: int,
) -> NDArray[np.float64]:
    """Harmonic forces of sliders on their points, as ``ElementLaw.forces_in_time``.

    The normal load of a slider is that of its spring and never negative; the friction force is that
    of its spring, bounded by mu times the normal load.
    """
    phase = 2 * np.pi * np.arange(1, samples + 1) / samples
    table = np.column_stack([np.sin(phase), np.cos(phase)])
    force = np.zeros_like(motion)
    springs = point, tangential_stiffness, normal_stiffness
    _integrate_friction(*springs, normal_load, friction_coefficient, motion, table, force)
    return force * np.tile([1 / samples, 2 / samples, 2 / samples], 2)


@kept_loop
def _integrate_friction(
    point_of_element: NDArray[np.int64],
    k_u: NDArray[np.float64],
    k_v: NDArray[np.float64] | None,
    normal_load: NDArray[np.float64],
    friction_coefficient: NDArray[np.float64],
    motion: NDArray[np.float64],
    table: NDArray[np.float64],
    force: NDArray[np.float64],
) -> None:
    """Sum friction and normal load change of all elements over a period, times 1, sine and cosine.

    Without a normal stiffness, numba compiles a version without the normal load.
    """
    # bias, sine and cosine of the spring forces; sums of the forces; state of the sliders
    x, n = np.empty((3, _LANES)), np.empty((3, _LANES))
    f_sum, n_sum = np.empty((3, _LANES)), np.empty((3, _LANES))
    mu, z = np.empty(_LANES), np.empty(_LANES)
    x_before, n_before = np.empty(_LANES), np.empty(_LANES)
    for first in range(0, k_u.size, _LANES):
        lanes = min(_LANES, k_u.size - first)
        for e in range(lanes):
            p = point_of_element[first + e]
            n[0, e], n[1, e], n[2, e] = normal_load[first + e], 0.0, 0.0
            for c in range(3):
                x[c, e] = k_u[first + e] * motion[p, c]
                if k_v is not None:
                    n[c, e] += k_v[first + e] * motion[p, 3 + c]
            mu[e] = friction_coefficient[first + e]
            # sliders start at zero traction; the period begins at sine 0, cosine 1
            z[e] = 0.0
            x_before[e], n_before[e] = x[0, e] + x[2, e], n[0, e] + n[2, e]
        f_sum[:] = 0.0
        n_sum[:] = 0.0
        for period in range(2):
            evaluated = period == 1
            for i in range(len(table)):
                sin, cos = table[i]
                for e in range(lanes):
                    x_now = x[0, e] + x[1, e] * sin + x[2, e] * cos
                    slider, load = z[e], n[0, e]
                    if k_v is not None:
                        n_now = n[0, e] + n[1, e] * sin + n[2, e] * cos
                        # on contact closing the slider restarts there, by linear interpolation
                        # between samples: the error of the force would else be of first order
                        part = n_before[e] / (n_before[e] - n_now)
                        closing = x_before[e] + (x_now - x_before[e]) * part
                        slider = closing if n_before[e] < 0.0 else slider
                        load = n_now if n_now > 0.0 else 0.0
                        x_before[e], n_before[e] = x_now, n_now
                        if evaluated:
                            n_sum[0, e] += load
                            n_sum[1, e] += load * sin
                            n_sum[2, e] += load * cos
                    lower, upper = x_now - mu[e] * load, x_now + mu[e] * load
                    slider = slider if slider > lower else lower
                    slider = slider if slider < upper else upper
                    z[e] = slider
                    if evaluated:
                        friction = x_now - slider
                        f_sum[0, e] += friction
                        f_sum[1, e] += friction * sin
                        f_sum[2, e] += friction * cos
        for e in range(lanes):
            p = point_of_element[first + e]
            for c in range(3):
                force[p, c] += f_sum[c, e]
                if k_v is not None:
                    force[p, 3 + c] += n_sum[c, e]
            if k_v is not None:
                force[p, 3] -= len(table) * max(normal_load[first + e], 0.0)
