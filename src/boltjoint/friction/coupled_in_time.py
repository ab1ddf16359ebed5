"""Friction of sliders in the plane with a circular limit, integrated in time.

No code is shared with AFT (``coupled_kernels``), so that either verifies the other: a slider that
slips moves in the direction that the friction has in the middle of the step, which is found by the
radial return of half the step (a midpoint rule, of second order in the step).
"""

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop

Array = NDArray[np.float64]

#: change of a slider over a period, relative to the largest limit, below which it is periodic, and
#: periods after which it counts as such, as in ``coupled_kernels``
_RETURN, _MOST_PERIODS = 1e-10, 1000


def integrate_in_plane(
    point: NDArray[np.int64], quantities: Array, motion: Array, samples: int
) -> Array:
    """Harmonic forces on points along t1, t2 and the normal, as ``forces_in_time``.

    Parameters
    ----------
    point
        Point of each element, shape (elements,).
    quantities
        k_u, k_v, n0 and mu of each, shape (4, elements).
    motion
        Bias, sine and cosine of the displacements along t1, t2 and the normal, shape (points, 9).
    samples
        Steps a period.
    """
    phase = 2 * np.pi * np.arange(samples) / samples
    table, middles = (
        np.column_stack([np.ones(samples), np.sin(each), np.cos(each)])
        for each in (phase, phase + np.pi / samples)
    )
    force = np.zeros_like(motion)
    for p, (k_u, k_v, load, mu) in zip(point, quantities.T, strict=True):
        springs = np.array([k_u, k_u, k_v])
        x, x_middle = (springs * (each @ motion[p].reshape(3, 3).T) for each in (table, middles))
        n, n_middle = load + x[:, 2], load + x_middle[:, 2]
        friction = np.zeros((samples, 2))
        _follow(x[:, :2].copy(), n, x_middle[:, :2].copy(), n_middle, mu, friction)
        change = np.maximum(n, 0.0) - max(load, 0.0)
        forces = np.column_stack([friction, change]).T @ table
        force[p] += (forces * [1 / samples, 2 / samples, 2 / samples]).ravel()
    return force


@kept_loop
def _follow(
    x: Array, n: Array, x_middle: Array, n_middle: Array, mu: float, friction: Array
) -> None:
    """Friction at the samples of the period in which the slider is periodic, (samples, 2)."""
    samples = len(x)
    z, e = np.zeros(2), np.zeros(2)
    smallest = _RETURN * mu * max(np.max(n), 0.0)
    for _ in range(_MOST_PERIODS):
        begin = z.copy()
        # a period ends at its first sample
        for i in range(1, samples + 1):
            at = i % samples
            if n[at] <= 0.0:
                z[:] = x[at]
                friction[at] = 0.0
                continue
            start = x[i - 1]
            halfway, half_limit = x_middle[i - 1], mu * max(n_middle[i - 1], 0.0)
            if n[i - 1] <= 0.0:
                # the slider restarts where the contact closes, by linear interpolation
                part = n[i - 1] / (n[i - 1] - n[at])
                z[:] = start + part * (x[at] - start)
                halfway, half_limit = 0.5 * (z + x[at]), 0.5 * mu * n[at]
            limit = mu * n[at]
            f = x[at] - z
            if f[0] * f[0] + f[1] * f[1] > limit * limit:
                e[:] = halfway - z
                size = np.sqrt(e[0] * e[0] + e[1] * e[1])
                if size > half_limit and half_limit > 0.0:
                    # the radial return moves the slider along the friction: its direction stays
                    e /= size
                else:
                    e[:] = f / np.sqrt(f[0] * f[0] + f[1] * f[1])
                # the slider moves by l along e, until the friction has the magnitude of the limit
                along = f[0] * e[0] + f[1] * e[1]
                beside = f[0] * e[1] - f[1] * e[0]
                if abs(beside) < limit:
                    moved = along - np.sqrt(limit * limit - beside * beside)
                else:
                    e[:] = f / np.sqrt(f[0] * f[0] + f[1] * f[1])
                    moved = np.sqrt(f[0] * f[0] + f[1] * f[1]) - limit
                z += moved * e
            friction[at] = x[at] - z
        change = z - begin
        if change[0] * change[0] + change[1] * change[1] <= smallest * smallest:
            break
