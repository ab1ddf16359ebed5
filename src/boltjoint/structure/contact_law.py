"""Law of unilateral, frictional contact while bolts are tightened: force and stiffness of pairs."""

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

Array = NDArray[np.float64]


def contact_force(
    relative: Array,
    stiffness: Array,
    friction_coefficient: float | Array,
    gap: Array | None = None,
) -> tuple[Array, Array]:
    """Force of each contact pair and its derivative by the relative displacement.

    With u in the plane, v along the normal (closing positive), k the penalty, g the initial gap::

        n = k max(v - g, 0)
        t = k u                where k |u| <= mu n  (stick)
        t = mu n u / |u|       elsewhere            (slip)

    Parameters
    ----------
    relative
        Shape (pairs, 3): along both tangents and the normal [m].
    stiffness
        k, shape (pairs,) [N/m].
    friction_coefficient
        mu [-], of all pairs or of each, shape (pairs,).
    gap
        g, shape (pairs,) [m]; 0 by default.

    Returns
    -------
    tuple
        Force (pairs, 3) [N] and its derivative (pairs, 3, 3) [N/m].

    Raises
    ------
    ValueError
        If shapes do not fit each other, or a number is out of range.
    """
    relative = checks.array("relative", relative, ("pairs", 3))
    stiffness = checks.array("stiffness", stiffness, relative.shape[:1], above=0)
    mu = np.broadcast_to(friction_coefficient, stiffness.shape)
    mu = checks.array("friction_coefficient", mu, stiffness.shape, at_least=0)
    gap = np.zeros(len(stiffness)) if gap is None else checks.array("gap", gap, stiffness.shape)
    return coulomb_contact(relative, stiffness, mu, gap)


def coulomb_contact(
    relative: Array,
    stiffness: Array,
    friction_coefficient: Array,
    gap: Array,
    tension: float = 0.0,
) -> tuple[Array, Array]:
    """As ``contact_force``, without checks; open pairs are springs of ``tension`` times k."""
    k, mu = stiffness, friction_coefficient
    u, v = relative[:, :2], relative[:, 2] - gap
    distance = np.linalg.norm(u, axis=1)
    closed = v > 0
    slip = closed & (distance > mu * v)
    stick = closed & ~slip

    force = np.zeros((len(k), 3))
    force[:, 2] = np.where(closed, k * v, 0.0)
    force[stick, :2] = k[stick, None] * u[stick]
    direction = u[slip] / distance[slip, None]
    force[slip, :2] = mu[slip, None] * force[slip, 2:] * direction

    derivative = np.zeros((len(k), 3, 3))
    derivative[closed, 2, 2] = k[closed]
    derivative[stick, 0, 0] = derivative[stick, 1, 1] = k[stick]
    if tension:
        force[~closed, 2] = tension * (k * v)[~closed]
        derivative[~closed, 2, 2] = tension * k[~closed]
    turning = np.eye(2) - direction[:, :, None] * direction[:, None, :]
    derivative[slip, :2, :2] = (mu[slip] * force[slip, 2] / distance[slip])[:, None, None] * turning
    derivative[slip, :2, 2] = mu[slip, None] * k[slip, None] * direction
    return force, derivative


def closed_and_sticking(
    stiffness: Array, friction_coefficient: Array, gap: Array
) -> tuple[Array, Array]:
    """Initial guess: force and stiffness of pairs that stick and are held closed, if by tension."""
    in_plane = np.where(friction_coefficient > 0, stiffness, 0.0)
    derivative = np.stack([in_plane, in_plane, stiffness], axis=-1)[:, :, None] * np.eye(3)
    force = np.zeros((len(stiffness), 3))
    force[:, 2] = -stiffness * gap
    return force, derivative
