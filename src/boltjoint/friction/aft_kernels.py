"""Compiled loops of AFT: friction forces marched through the samples of a period."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

#: what an element does at a sample: slip, by the sign of its force, stick, be open, or stick where
#: the surfaces have met since the sample before
SLIPS_NEGATIVE, STICKS, SLIPS_POSITIVE, OPEN, CLOSES = range(-1, 4)


@njit(cache=True)
def move_slider(
    x_before: float, n_before: float, x: float, n: float, mu: float, z: float
) -> tuple[float, int]:
    """Where the slider is after a sample, and what the element does there.

    ``x = k_u u`` and ``n = n0 + k_v v`` are what the springs alone want, z is where the slider was.
    """
    if n <= 0.0:
        return x, OPEN
    doing = STICKS
    if n_before <= 0.0:
        # laid down where n rises through zero, by a straight line from sample to sample: only then
        # does the force err by the square of the step
        z, doing = x_before + (x - x_before) * n_before / (n_before - n), CLOSES
    if z < x - mu * n:
        return x - mu * n, SLIPS_POSITIVE
    if z > x + mu * n:
        return x + mu * n, SLIPS_NEGATIVE
    return z, doing


@njit(cache=True)
def march_points(
    order: NDArray[np.int64],
    first: NDArray[np.int64],
    k_u: NDArray[np.float64],
    k_v: NDArray[np.float64],
    normal_load: NDArray[np.float64],
    friction_coefficient: NDArray[np.float64],
    motion: NDArray[np.float64],
    tables: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    force: NDArray[np.float64],
    tangent: NDArray[np.float64],
) -> None:
    """March the elements point by point, and find the harmonic tangents where there is room."""
    synthesis = tables[0]
    count, samples = synthesis.shape
    directions = motion.shape[1] // count
    displacement, total = np.empty((directions, samples)), np.empty((directions, samples))
    x, n, doing = np.empty(samples), np.empty(samples), np.empty(samples, dtype=np.int8)
    for p in range(len(motion)):
        total[:] = 0.0
        for d in range(directions):
            np.dot(motion[p, d * count : (d + 1) * count], synthesis, displacement[d])
        for e in order[first[p] : first[p + 1]]:
            mu, preload = friction_coefficient[e], max(normal_load[e], 0.0)
            for i in range(samples):
                x[i] = k_u[e] * displacement[0, i]
                n[i] = normal_load[e]
                if directions == 2:
                    n[i] += k_v[e] * displacement[1, i]
            z, placed_at, placed_by = 0.0, 0, STICKS
            for i in range(samples):
                z, does = move_slider(x[i - 1], n[i - 1], x[i], n[i], mu, z)
                if does != STICKS:
                    placed_at, placed_by = i, does
            for i in range(samples):
                z, doing[i] = move_slider(x[i - 1], n[i - 1], x[i], n[i], mu, z)
                total[0, i] += x[i] - z
                if directions == 2:
                    total[1, i] += max(n[i], 0.0) - preload
            if tangent.size:
                springs = k_u[e], k_v[e], mu
                _add_tangent(springs, x, n, doing, placed_at, placed_by, tables, tangent[p])
        for d in range(directions):
            np.dot(synthesis, total[d], force[p, d * count : (d + 1) * count])


@njit(cache=True)
def _add_tangent(
    springs: tuple[float, float, float],
    x: NDArray[np.float64],
    n: NDArray[np.float64],
    doing: NDArray[np.int8],
    placed_at: int,
    placed_by: int,
    tables: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    tangent: NDArray[np.float64],
) -> None:
    """Add the harmonic tangent of one element.

    Over a stretch of samples at which it does the same, its forces are linear in the motion: n, and
    ``mu n`` or ``x - z``, with z as the slider was placed at one sample.
    """
    k_u, k_v, mu = springs
    synthesis, mean, square = tables
    count = len(synthesis)
    has_normal = len(tangent) > count
    begin = 0
    for end in range(1, doing.size + 1):
        does = doing[begin]
        if end < doing.size and doing[end] == does:
            continue
        slips = does in (SLIPS_NEGATIVE, SLIPS_POSITIVE)
        if does == CLOSES:
            placed_at, placed_by = begin, does
        if does != OPEN:
            of_x = 0.0 if slips else k_u
            of_n = does * mu * k_v if slips else 0.0
            for i in range(count):
                for j in range(count):
                    both = square[end, i, j] - square[begin, i, j]
                    tangent[i, j] += of_x * both
                    if has_normal:
                        tangent[i, count + j] += of_n * both
                        tangent[count + i, count + j] += k_v * both
            if not slips and placed_by != STICKS:
                share, by_n_before, by_n = slider_placement(x, n, mu, placed_at, placed_by)
                for j in range(count):
                    phi_before, phi = synthesis[j, placed_at - 1], synthesis[j, placed_at]
                    z_by_x = k_u * (phi_before + share * (phi - phi_before))
                    z_by_n = k_v * (by_n_before * phi_before + by_n * phi)
                    for i in range(count):
                        weight = mean[end, i] - mean[begin, i]
                        tangent[i, j] -= weight * z_by_x
                        if has_normal:
                            tangent[i, count + j] -= weight * z_by_n
        if slips:
            placed_at, placed_by = end - 1, does
        begin = end


@njit(cache=True)
def slider_placement(
    x: NDArray[np.float64], n: NDArray[np.float64], mu: float, at: int, by: int
) -> tuple[float, float, float]:
    """How a slider placed at a sample depends on it and the one before.

    Share of x at the sample, the rest being of x before; derivative by n before, and by n.
    """
    if by != CLOSES:
        return 1.0, 0.0, -by * mu
    drop = n[at - 1] - n[at]
    slope = (x[at] - x[at - 1]) / drop**2
    return n[at - 1] / drop, -n[at] * slope, n[at - 1] * slope
