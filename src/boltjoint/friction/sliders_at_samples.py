"""Springs with sliders, followed through the samples of a period (AFT), and their forces."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop

Array = NDArray[np.float64]


class SampleTables(NamedTuple):
    """Components of motion and force at the samples of a period.

    ``synthesis`` has their values, shape (components, samples), and ``weight`` the weight of a
    sample in each; ``mean`` the sums of the weighted values up to a sample, (samples + 1,
    components), and ``square`` those of their products with each component of the motion, (samples
    + 1, components, components).
    """

    synthesis: Array
    weight: Array
    mean: Array
    square: Array


#: contact state at a sample: slip by the sign of its force, stick, separation, or stick after the
#: contact has closed since the sample before
SLIP_NEGATIVE, STICK, SLIP_POSITIVE, SEPARATION, CLOSING = range(-1, 4)


@kept_loop
def move_slider(
    x_before: float, n_before: float, x: float, n: float, mu: float, z: float
) -> tuple[float, int]:
    """Slider position after a sample, and contact state there.

    ``x = k_u u`` and ``n = n0 + k_v v`` are the forces of the springs alone, z the last position.
    """
    if n <= 0.0:
        return x, SEPARATION
    state = STICK
    if n_before <= 0.0:
        # closing where n rises through zero, by linear interpolation between the samples: only then
        # is the error of the force of second order
        z, state = x_before + (x - x_before) * n_before / (n_before - n), CLOSING
    if z < x - mu * n:
        return x - mu * n, SLIP_POSITIVE
    if z > x + mu * n:
        return x + mu * n, SLIP_NEGATIVE
    return z, state


@kept_loop
def move_through_period(
    x: Array, n: Array, mu: float, friction: Array, state: NDArray[np.int8]
) -> tuple[int, int]:
    """Friction and states of a second period; sample and state that set the slider in the first."""
    z, slider_sample, slider_state = 0.0, 0, STICK
    for i in range(x.size):
        z, current = move_slider(x[i - 1], n[i - 1], x[i], n[i], mu, z)
        if current != STICK:
            slider_sample, slider_state = i, current
    for i in range(x.size):
        z, state[i] = move_slider(x[i - 1], n[i - 1], x[i], n[i], mu, z)
        friction[i] = x[i] - z
    return slider_sample, slider_state


@kept_loop
def add_forces(
    order: NDArray[np.int64],
    first: NDArray[np.int64],
    elements: tuple[Array, ...],
    motion: Array,
    tables: SampleTables,
    force: Array,
    tangent: Array,
) -> None:
    """Add the harmonic forces, and the tangents where their array is not empty, by point."""
    k_u, k_v, normal_load, friction_coefficient = elements
    synthesis = tables.synthesis
    count, samples = synthesis.shape
    directions = motion.shape[1] // count
    displacement, total = np.empty((directions, samples)), np.empty((directions, samples))
    x, n, friction = np.empty(samples), np.empty(samples), np.empty(samples)
    state = np.empty(samples, dtype=np.int8)
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
            slider_sample, slider_state = move_through_period(x, n, mu, friction, state)
            for i in range(samples):
                total[0, i] += friction[i]
                if directions == 2:
                    total[1, i] += max(n[i], 0.0) - preload
            if tangent.size:
                springs = k_u[e], k_v[e], mu
                _add_tangent(springs, x, n, state, slider_sample, slider_state, tables, tangent[p])
        for d in range(directions):
            np.dot(synthesis, total[d], force[p, d * count : (d + 1) * count])


@kept_loop
def _add_tangent(
    springs: tuple[float, float, float],
    x: Array,
    n: Array,
    state: NDArray[np.int8],
    slider_sample: int,
    slider_state: int,
    tables: SampleTables,
    tangent: Array,
) -> None:
    """Add the harmonic tangent of one element.

    Over an interval of samples in one state its forces are linear in the motion: n, and ``mu n`` or
    ``x - z``, with z determined at one sample.
    """
    k_u, k_v, mu = springs
    synthesis, mean, square = tables.synthesis, tables.mean, tables.square
    count = len(synthesis)
    has_normal = len(tangent) > count
    begin = 0
    for end in range(1, state.size + 1):
        current = state[begin]
        if end < state.size and state[end] == current:
            continue
        slips = current in (SLIP_NEGATIVE, SLIP_POSITIVE)
        if current == CLOSING:
            slider_sample, slider_state = begin, current
        if current != SEPARATION:
            of_x = 0.0 if slips else k_u
            of_n = current * mu * k_v if slips else 0.0
            for i in range(count):
                for j in range(count):
                    both = square[end, i, j] - square[begin, i, j]
                    tangent[i, j] += of_x * both
                    if has_normal:
                        tangent[i, count + j] += of_n * both
                        tangent[count + i, count + j] += k_v * both
            if not slips and slider_state != STICK:
                share, by_n_before, by_n = slider_derivative(x, n, mu, slider_sample, slider_state)
                for j in range(count):
                    phi_before, phi = synthesis[j, slider_sample - 1], synthesis[j, slider_sample]
                    z_by_x = k_u * (phi_before + share * (phi - phi_before))
                    z_by_n = k_v * (by_n_before * phi_before + by_n * phi)
                    for i in range(count):
                        weight = mean[end, i] - mean[begin, i]
                        tangent[i, j] -= weight * z_by_x
                        if has_normal:
                            tangent[i, count + j] -= weight * z_by_n
        if slips:
            slider_sample, slider_state = end - 1, current
        begin = end


@kept_loop
def slider_derivative(
    x: Array, n: Array, mu: float, at: int, by: int
) -> tuple[float, float, float]:
    """Derivatives of a slider position determined at a sample, by this sample and the one before.

    By x, one minus that by x before; by n before; and by n.
    """
    if by != CLOSING:
        return 1.0, 0.0, -by * mu
    drop = n[at - 1] - n[at]
    slope = (x[at] - x[at - 1]) / drop**2
    return n[at - 1] / drop, -n[at] * slope, n[at - 1] * slope


@dataclass(frozen=True)
class Sliders:
    """Springs in series with sliders, whose forces add up to those of the elements of a law.

    They follow any motion, so they are what AFT and time integration know of a law. Each belongs to
    an ``element``, acts on a ``point``, both counted from 0, and slips at the friction coefficient
    times the normal load [N], which is constant where ``normal_stiffness`` is None; all have the
    shape (sliders,). Those that are ``lateral`` slide along the second tangent, and have the
    normal spring in common with another slider of their element; None where all slide along it.
    """

    element: NDArray[np.int64]
    point: NDArray[np.int64]
    tangential_stiffness: Array
    normal_stiffness: Array | None
    normal_load: Array
    friction_coefficient: Array
    lateral: NDArray[np.bool_] | None = None


def joined(parts: Sequence[Sliders], first: Iterable[int]) -> Sliders:
    """Sliders of several sets of elements, by the number of the first element of each."""
    absent = {"normal_stiffness": 0.0, "lateral": False}
    values: dict[str, Any] = {
        name: [getattr(part, name) for part in parts] for name in vars(parts[0])
    }
    values["element"] = [
        start + number for start, number in zip(first, values["element"], strict=True)
    ]
    for name, none in absent.items():
        if all(value is None for value in values[name]):
            del values[name]
            continue
        values[name] = [
            np.full(part.point.shape, none) if value is None else value
            for part, value in zip(parts, values[name], strict=True)
        ]
    whole: dict[str, Any] = {name: np.concatenate(of_parts) for name, of_parts in values.items()}
    return Sliders(**{**dict.fromkeys(absent), **whole})


def slider_forces(sliders: Sliders, motion: Array, tables: SampleTables, tangent: Array) -> Array:
    """Harmonic forces of sliders on their points, and their tangents.

    Each direction of motion is on its own.

    Parameters
    ----------
    sliders
        The springs with sliders of a law.
    motion
        As for ``FrictionLaw.force``.
    tables
        Components of motion and force at the samples.
    tangent
        To which the tangents are added, or empty.
    """
    if sliders.lateral is None:
        return _forces(sliders, slice(None), motion, tables, tangent)
    count = tables.weight.size
    blocks = np.arange(motion.shape[1]).reshape(-1, count)
    normal = blocks[2:].ravel()
    force = np.zeros_like(motion)
    for own, mine in zip(blocks[:2], (~sliders.lateral, sliders.lateral), strict=True):
        at = np.concatenate([own, normal])
        of_direction = np.zeros((len(tangent), at.size, at.size))
        acting_forces = _forces(sliders, mine, motion[:, at], tables, of_direction)
        # both directions have the normal load in common, and it acts once
        acting = slice(None) if own[0] == 0 else slice(count)
        force[:, at[acting]] += acting_forces[:, acting]
        tangent[:, at[acting, None], at] += of_direction[:, acting]
    return force


def _forces(
    sliders: Sliders,
    mine: NDArray[np.bool_] | slice,
    motion: Array,
    tables: SampleTables,
    tangent: Array,
) -> Array:
    """Forces of some sliders along one direction, and across the contact."""
    on, k_u = sliders.point[mine], sliders.tangential_stiffness[mine]
    k_v = sliders.normal_stiffness
    k_v = np.zeros_like(k_u) if k_v is None else k_v[mine]
    of_element = k_u, k_v, sliders.normal_load[mine], sliders.friction_coefficient[mine]
    order = np.argsort(on, kind="stable")
    first = np.searchsorted(on[order], np.arange(len(motion) + 1))
    motion, force = np.ascontiguousarray(motion), np.zeros(motion.shape)
    add_forces(order, first, of_element, motion, tables, force, tangent)
    return force * np.tile(tables.weight, motion.shape[1] // tables.weight.size)
