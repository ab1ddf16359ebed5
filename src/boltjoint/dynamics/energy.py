"""Energy of a periodic motion: what comes in, and what structure and friction dissipate."""

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.harmonic_balance import HarmonicBalance, parse_component


def energy_per_period(
    balance: HarmonicBalance, x: NDArray[np.float64], w: float
) -> tuple[float, float, float]:
    """Input energy, structural dissipation and friction dissipation in a period [J].

    The work of a force f on a displacement q is ``pi sum_h h (f_ch s_h - f_sh c_h)``. Input and
    dissipation balance where the equations hold in a space that holds q.

    Parameters
    ----------
    balance
        With the excitation.
    x, w
        An unknown of the balance, and the frequency [rad/s].
    """
    q = x.reshape(len(balance.components), -1)
    place = {parse_component(name): i for i, name in enumerate(balance.components)}

    def work(force: NDArray[np.float64]) -> float:
        f = force.reshape(q.shape)
        harmonics = [(h, place["sin", h], place["cos", h]) for part, h in place if part == "sin"]
        return float(np.pi * sum(h * (f[c] @ q[s] - f[s] @ q[c]) for h, s, c in harmonics))

    force = balance.modal_force, balance.damping_force(x, w), balance.contact.force(x)
    return work(force[0]), work(force[1]), work(force[2])


def energy_error(balance: HarmonicBalance, x: NDArray[np.float64], w: float) -> float:
    """Input energy less dissipation, over the larger of both; 0 without motion."""
    supplied, structural, friction = energy_per_period(balance, x, w)
    larger = max(abs(supplied), abs(structural + friction))
    return (supplied - structural - friction) / max(larger, np.finfo(float).tiny)
