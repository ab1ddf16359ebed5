"""Compiled loops of AFT in modal coordinates: sliders followed, and sums of their derivatives."""

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop
from boltjoint.friction.sliders_at_samples import (
    CLOSING,
    SEPARATION,
    SLIP_NEGATIVE,
    SLIP_POSITIVE,
    STICK,
    Array,
    move_slider,
    slider_derivative,
)


@kept_loop
def sum_stiffness(
    of_state: Array, by_motion: Array, R: Array, N: Array, V: Array, stiffness: Array
) -> None:
    """Add the stiffness of the elements from where states begin to where they end, to zeros.

    ``by_motion`` has the derivatives of the friction by the modes, (states, modes); N and V are
    empty where the normal load is constant.
    """
    samples, modes = stiffness.shape[:2]
    for row in range(len(of_state)):
        begin, e, end = int(of_state[row, 0]), int(of_state[row, 1]), int(of_state[row, 4])
        for r in range(modes):
            for s in range(modes):
                k = R[e, r] * by_motion[row, s]
                if len(V):
                    k += N[e, r] * V[e, s]
                stiffness[begin, r, s] += k
                if end < samples:
                    stiffness[end, r, s] -= k
    for sample in range(1, samples):
        for r in range(modes):
            for s in range(modes):
                stiffness[sample, r, s] += stiffness[sample - 1, r, s]


@kept_loop
def sum_products(
    real: Array,
    imaginary: Array,
    harmonic: NDArray[np.int64],
    is_sine: NDArray[np.bool_],
    weight: Array,
    products: Array,
) -> None:
    """Sums over the samples of products of two components and the stiffness, by its spectrum.

    The spectrum is the sum with cos, less i times that with sin.
    """
    samples, modes = real.shape[:2]
    for i in range(harmonic.size):
        for j in range(harmonic.size):
            total = (harmonic[i] + harmonic[j]) % samples
            difference = (harmonic[i] - harmonic[j]) % samples
            part = real if is_sine[i] == is_sine[j] else imaginary
            of_total = weight[i] if not is_sine[i] and not is_sine[j] else -weight[i]
            of_difference = -weight[i] if is_sine[i] and not is_sine[j] else weight[i]
            for r in range(modes):
                for s in range(modes):
                    products[i, r, j, s] = (
                        of_difference * part[difference, r, s] + of_total * part[total, r, s]
                    )


@kept_loop
def sum_positions(
    element: NDArray[np.int64],
    by_motion: Array,
    held: Array,
    first: NDArray[np.int64],
    R: Array,
    rows: Array,
) -> None:
    """Derivatives of forces by the displacement at samples, of the sliders determined there.

    The changes of the sample k are those from ``first[k]`` on, of which rows has the row k.
    ``by_motion`` has the derivatives of their positions by the modes, (changes, modes).
    """
    modes, count = R.shape[1], held.shape[1]
    most = 0
    for k in range(len(rows)):
        most = max(most, first[k + 1] - first[k])
    together = np.empty((most, modes * modes), R.dtype)
    for k in range(len(rows)):
        both = together[: first[k + 1] - first[k]]
        for number in range(len(both)):
            change = first[k] + number
            for r in range(modes):
                for s in range(modes):
                    both[number, r * modes + s] = R[element[change], r] * by_motion[change, s]
        np.dot(held[first[k] : first[k + 1]].T, both, rows[k].reshape(count, modes * modes))


@kept_loop
def subtract(by_slider: Array, tangent: Array) -> None:
    """Take derivatives (components, modes, modes, components) from those in the order of both."""
    count, modes = tangent.shape[:2]
    for i in range(count):
        for r in range(modes):
            for j in range(count):
                for s in range(modes):
                    tangent[i, r, j, s] -= by_slider[i, r, s, j]


@kept_loop
def _set(row: Array, values: tuple[float, ...]) -> None:
    """Set the columns of a row."""
    for column, value in enumerate(values):
        row[column] = value


@kept_loop
def follow(x: Array, n: Array, friction_coefficient: Array, friction: Array) -> tuple:
    """Follow the elements through the period: their friction, and where derivatives change.

    One sample of all elements after another: each waits for its own slider, not for those of
    others. A constant normal load has one sample.
    """
    samples, elements = x.shape
    slider, slider_sample = np.zeros(elements), np.zeros(elements, dtype=np.int64)
    slider_state = np.full(elements, STICK)
    for i in range(samples):
        x_before, x_now, n_before, n_now = x[i - 1], x[i], n[(i - 1) % len(n)], n[i % len(n)]
        for e in range(elements):
            slider[e], state = move_slider(
                x_before[e], n_before[e], x_now[e], n_now[e], friction_coefficient[e], slider[e]
            )
            if state != STICK:
                slider_sample[e], slider_state[e] = i, state
    of_state, of_slider = np.empty((8 * elements + 8, 5)), np.empty((4 * elements + 4, 6))
    states = sliders = 0
    current, begins = np.full(elements, STICK), np.zeros(elements, dtype=np.int64)
    for i in range(samples + 1):
        # after the last sample all states end
        ends, now = i == samples, i % samples
        x_before, x_now, n_before, n_now = x[now - 1], x[now], n[(i - 1) % len(n)], n[i % len(n)]
        for e in range(elements):
            mu, state = friction_coefficient[e], STICK
            if not ends:
                slider[e], state = move_slider(
                    x_before[e], n_before[e], x_now[e], n_now[e], mu, slider[e]
                )
                friction[now, e] = x_now[e] - slider[e]
                if i == 0:
                    current[e] = state
                if state == current[e]:
                    continue
            if states + 1 > len(of_state):
                of_state = np.concatenate((of_state, np.empty_like(of_state)))
            if sliders + 2 > len(of_slider):
                of_slider = np.concatenate((of_slider, np.empty_like(of_slider)))
            before, begin = current[e], begins[e]
            slips = before == SLIP_NEGATIVE or before == SLIP_POSITIVE
            if before == CLOSING:
                slider_sample[e], slider_state[e] = begin, before
            if before != SEPARATION:
                by_x, by_n = (0.0, before * mu) if slips else (1.0, 0.0)
                _set(of_state[states], (float(begin), float(e), by_x, by_n, float(i)))
                states += 1
                if not slips and slider_state[e] != STICK:
                    sample = slider_sample[e]
                    part, by_n_before, by_n = slider_derivative(
                        x[:, e], n[:, e], mu, sample, slider_state[e]
                    )
                    during = float(begin), float(i)
                    _set(of_slider[sliders], (float(sample), float(e), part, by_n, *during))
                    sliders += 1
                    if slider_state[e] == CLOSING:
                        at = float((sample - 1) % samples), float(e)
                        _set(of_slider[sliders], (*at, 1.0 - part, by_n_before, *during))
                        sliders += 1
            if slips:
                slider_sample[e], slider_state[e] = i - 1, before
            current[e], begins[e] = state, i
    return of_state[:states], of_slider[:sliders]


@kept_loop
def follow_change(
    x: Array, n: Array, of_state: Array, of_slider: Array, friction: Array, load: Array
) -> None:
    """Add the changes of friction and load by those of x and n, (samples, elements).

    A normal load that is constant has none.
    """
    varies = n.shape == x.shape
    for row in range(len(of_state)):
        e, by_x, by_n = int(of_state[row, 1]), of_state[row, 2], of_state[row, 3]
        for i in range(int(of_state[row, 0]), int(of_state[row, 4])):
            friction[i, e] += by_x * x[i, e]
            if varies:
                friction[i, e] += by_n * n[i, e]
                load[i, e] += n[i, e]
    for row in range(len(of_slider)):
        sample, e = int(of_slider[row, 0]), int(of_slider[row, 1])
        position = of_slider[row, 2] * x[sample, e]
        if varies:
            position += of_slider[row, 3] * n[sample, e]
        for i in range(int(of_slider[row, 4]), int(of_slider[row, 5])):
            friction[i, e] -= position


@kept_loop
def hold(position: Array, of_slider: Array, R: Array, held: Array) -> None:
    """Add the forces of slider positions where they begin, and take them away where they end."""
    samples, modes = held.shape
    for row in range(len(of_slider)):
        e, begin, end = int(of_slider[row, 1]), int(of_slider[row, 4]), int(of_slider[row, 5])
        for mode in range(modes):
            force = position[row] * R[e, mode]
            held[begin, mode] += force
            if end < samples:
                held[end, mode] -= force
