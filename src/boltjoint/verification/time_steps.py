"""Compiled time steps of modes with sliders: second-order backward differences (BDF2).

Backward differences damp what the steps do not resolve, such as the motion of vectors of a
contact-adapted basis far above the excitation. The equations of a step are linear between changes
of contact state; Newton's method solves them, and its matrix changes with the elements that do.

References
----------
E. Hairer, G. Wanner: Solving Ordinary Differential Equations II. Springer, second edition, 1996:
chapter V.1.
"""

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop

Array = NDArray[np.float64]

#: iterations after which a step counts as not solved, and change of the motion, over its largest in
#: the period, at which it is
_ITERATIONS, _TOLERANCE = 40, 1e-11


@kept_loop
def _follow_sliders(
    x: Array,
    n: Array,
    x_before: Array,
    n_before: Array,
    mu: Array,
    z: Array,
    friction: Array,
    by_motion: Array,
) -> None:
    """Friction of elements whose sliders were at z, and its derivatives by x and n.

    ``x = k_u u`` and ``n = n0 + k_v v``; under constant normal load n is empty, and mu the slip
    force. The rows of the derivatives are by x, by n, and of the load ``max(n, 0)`` by n.
    """
    for e in range(z.size):
        trial, by_x, by_n, limit, limit_by_n = x[e] - z[e], 1.0, 0.0, mu[e], 0.0
        if n.size:
            by_motion[2, e] = 1.0 if n[e] > 0.0 else 0.0
            if n[e] <= 0.0:
                friction[e] = by_motion[0, e] = by_motion[1, e] = 0.0
                continue
            if n_before[e] < 0.0:
                # the slider restarts where the contact closes, by linear interpolation
                span, moved = n[e] - n_before[e], x[e] - x_before[e]
                by_x, by_n = n[e] / span, -moved * n_before[e] / span**2
                trial = moved * by_x
            limit, limit_by_n = mu[e] * n[e], mu[e]
        if abs(trial) > limit:
            sign = 1.0 if trial > 0.0 else -1.0
            trial, by_x, by_n = sign * limit, 0.0, sign * limit_by_n
        friction[e], by_motion[0, e], by_motion[1, e] = trial, by_x, by_n


@kept_loop
def integrate_period(
    q: Array,
    v: Array,
    z: Array,
    of_elements: tuple[Array, Array, Array, Array, Array, Array],
    of_modes: tuple[Array, Array, NDArray[np.complex128]],
    w: float,
    factors: tuple[float, float],
    history: Array,
) -> int:
    """Integrate a period, changing the state in place; returns the number of steps not solved.

    Parameters
    ----------
    q, v
        Motion [kg^1/2 m] and its velocity, now and their last change, shape (2, modes).
    z
        Sliders, as forces of the springs [N], shape (elements,).
    of_elements
        Rows k_u R, k_v N, R and N, shape (elements, modes), of which those with N are without rows
        under constant normal load; normal load and friction coefficient, or empty and slip force.
    of_modes
        L, shape (modes,); C, (modes, modes); sine + i cosine of the force on the modes, (modes,).
    w
        Frequency of the excitation [rad/s].
    factors
        Factors of the force at the begin and the end of the period.
    history
        Filled with the motion at the begin of each step, shape (steps, modes).
    """
    X, V, R, N, normal_load, mu = of_elements
    stiffness, damping, force = of_modes
    steps = len(history)
    elements, h = z.size, 2 * np.pi / w / steps
    jacobian = 1.5 / h * damping + np.diag(2.25 / h**2 + stiffness)
    inverse = np.linalg.inv(jacobian)
    used, by_motion = np.zeros((3, elements)), np.zeros((3, elements))
    friction = np.zeros(elements)
    largest, unsolved = 0.0, 0
    at_rest = np.maximum(normal_load, 0.0)
    x_before, n_before = np.dot(X, q[0]), np.dot(V, q[0]) + normal_load
    for i in range(steps):
        history[i] = q[0]
        part, phase = (i + 1) / steps, 2 * np.pi * ((i + 1) % steps) / steps
        factor = factors[0] + (factors[1] - factors[0]) * part
        pull = factor * (force.real * np.sin(phase) + force.imag * np.cos(phase))
        # increments, whose differences round less than those of the motion
        step = h * (v[0] + 0.5 * v[1])
        new = q[0] + step
        x, n = np.dot(X, new), np.dot(V, new) + normal_load
        _follow_sliders(x, n, x_before, n_before, mu, z, friction, by_motion)
        if _update(jacobian, used, by_motion, X, V, R, N):
            inverse = np.linalg.inv(jacobian)
        solved = False
        for _ in range(_ITERATIONS):
            velocity = (3 * step - q[1]) / (2 * h)
            residual = (3 * (velocity - v[0]) - v[1]) / (2 * h) + np.dot(damping, velocity)
            residual += stiffness * new - pull + np.dot(friction, R)
            residual += np.dot(np.maximum(n, 0.0) - at_rest, N)
            change = np.dot(inverse, residual)
            step = step - change
            new = q[0] + step
            x, n = np.dot(X, new), np.dot(V, new) + normal_load
            _follow_sliders(x, n, x_before, n_before, mu, z, friction, by_motion)
            # while no state changes the equations are linear, and solved at once
            changed = _update(jacobian, used, by_motion, X, V, R, N)
            largest = max(largest, np.sqrt(np.dot(new, new)))
            solved = not changed or np.sqrt(np.dot(change, change)) <= _TOLERANCE * largest
            if changed:
                inverse = np.linalg.inv(jacobian)
            if solved:
                break
        unsolved += not solved
        for e in range(elements):
            z[e] = x[e] - friction[e]
        velocity = (3 * step - q[1]) / (2 * h)
        v[1] = velocity - v[0]
        q[0], q[1], v[0] = new, step, velocity
        x_before, n_before = x, n
    return unsolved


@kept_loop
def _update(
    jacobian: Array,
    used: Array,
    by_motion: Array,
    X: Array,
    V: Array,
    R: Array,
    N: Array,
) -> bool:
    """Add to a matrix what elements have changed by; whether any has."""
    changed, modes = False, jacobian.shape[0]
    for e in range(used.shape[1]):
        by_x, by_n = by_motion[0, e] - used[0, e], by_motion[1, e] - used[1, e]
        load_by_n = by_motion[2, e] - used[2, e]
        if by_x == 0.0 and by_n == 0.0 and load_by_n == 0.0:
            continue
        changed = True
        for k in range(3):
            used[k, e] = by_motion[k, e]
        for i in range(modes):
            for j in range(modes):
                jacobian[i, j] += R[e, i] * by_x * X[e, j]
                if V.size:
                    jacobian[i, j] += (R[e, i] * by_n + N[e, i] * load_by_n) * V[e, j]
    return changed


@kept_loop
def sliders_along(
    motion: Array, z: Array, X: Array, V: Array, normal_load: Array, mu: Array
) -> None:
    """Move sliders along a motion, shape (samples, modes), for two periods from 0 to its begin."""
    friction, by_motion = np.empty(z.size), np.empty((3, z.size))
    z[:] = 0.0
    x_before, n_before = np.dot(X, motion[-1]), np.dot(V, motion[-1]) + normal_load
    for i in range(2 * len(motion) + 1):
        at = motion[i % len(motion)]
        x, n = np.dot(X, at), np.dot(V, at) + normal_load
        _follow_sliders(x, n, x_before, n_before, mu, z, friction, by_motion)
        for e in range(z.size):
            z[e] = x[e] - friction[e]
        x_before, n_before = x, n
