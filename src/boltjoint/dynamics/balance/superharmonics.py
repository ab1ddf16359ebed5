"""Superharmonic resonances: a harmonic of the motion in resonance with a mode of its own.

The harmonic h of a motion vibrates at h times the excitation frequency w. For a small change of it
at that frequency the structure with its contact has the complex stiffness ``L + i H(hw) + K_h``,
K_h from the tangent of the contact at the motion itself. Where an eigenvalue lambda of that matrix
is so near to (hw)^2 that its damping, not its stiffness, limits the motion, the harmonic is in
resonance: ``|Re lambda - (hw)^2| <= Im lambda``, the half-power bandwidth. Motion with a damping
ratio above a quarter, such as that of points that slip, has no resonance.

References
----------
A. H. Nayfeh, D. T. Mook: Nonlinear Oscillations. Wiley, 1979: section 4.1.3.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.balance.harmonic_balance import (
    HarmonicBalance,
    stiffness_of_harmonic,
)
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion


class Superharmonic(NamedTuple):
    """A harmonic in resonance.

    ``order`` of the harmonic; ``frequency`` [Hz] of the mode, near order times that of the motion;
    ``share``: amplitude of the mode in that harmonic over that of all modes in the first, both in
    modal coordinates.
    """

    order: int
    frequency: float
    share: float


def find_superharmonic(
    balance: HarmonicBalance,
    jacobian: NDArray[np.float64],
    motion: PeriodicMotion,
    frequency: float,
    smallest_share: float = 1e-3,
) -> Superharmonic | None:
    """The superharmonic resonance with the largest share in a motion; None without one.

    Parameters
    ----------
    balance
        With the harmonics of the motion, in linear modes.
    jacobian
        Jacobian of the balance at the motion.
    motion, frequency
        A solution, and its frequency [Hz].
    smallest_share
        Smallest share of a resonance that counts: high harmonics pass many resonances with hardly
        any motion.
    """
    w = 2 * np.pi * frequency
    q = motion.in_components(balance.components)
    components = balance.components
    first = np.linalg.norm(q[[components.sin(), components.cos()]])
    resonances = []
    for h, s, c in components.harmonics:
        if h == 1:
            continue
        distance, vectors = np.linalg.eig(stiffness_of_harmonic(jacobian, components, h))
        amplitude = q[s] + 1j * q[c]
        share = abs(np.linalg.solve(vectors, amplitude)) / first
        squared = distance.real + (h * w) ** 2
        is_resonant = (abs(distance.real) <= distance.imag) & (2 * distance.imag < squared)
        for mode in np.flatnonzero(is_resonant & (share >= smallest_share)):
            own = np.sqrt(squared[mode]) / (2 * np.pi)
            resonances.append(Superharmonic(h, float(own), float(share[mode])))
    return max(resonances, key=lambda resonance: resonance.share, default=None)
