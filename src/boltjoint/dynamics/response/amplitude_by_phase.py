"""The logarithm of an amplitude by the phase of its motion, near the peak.

Friction that is sampled makes amplitudes rough, so that their peak is told by parabolas of phases
that are far enough apart, and by how far the amplitudes are from smooth curves.
"""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Parabola(NamedTuple):
    """Of the logarithm of the amplitude through three phases ``spread`` apart, the middle highest.

    ``vertex``, ``highest`` there; ``sharpness``, minus its second derivative;
    ``frequency_by_phase``, the largest change of ln w by the phase; ``distance`` by which the
    vertex may be off.
    """

    spread: float
    vertex: float
    highest: float
    sharpness: float
    frequency_by_phase: float
    distance: float

    @classmethod
    def through(cls, phases: Array, values: Array, log_frequency: Array) -> Self:
        """Through the values at three phases, with ln w there, all of shape (3,)."""
        spread = phases[1] - phases[0]
        by_value = np.polyfit([-1.0, 0.0, 1.0], values, 2)
        vertex = -by_value[1] / (2 * by_value[0]) if by_value[0] < 0 else 0.0
        return cls(
            spread=spread,
            vertex=phases[1] + spread * vertex,
            highest=float(np.polyval(by_value, vertex)),
            sharpness=-2 * by_value[0] / spread**2,
            frequency_by_phase=max(abs(np.diff(log_frequency))) / spread,
            distance=spread,
        )


def deviation_from_cubic(at: Array, values: Array) -> float:
    """Standard deviation of values from a cubic polynomial; zero of four or fewer."""
    if len(at) <= 4:
        return 0.0
    left = values - np.polyval(np.polyfit(at, values, 3), at)
    return float(np.linalg.norm(left) / np.sqrt(len(at) - 4))


def rise_within(distance: float, phase: float, phases: Array, values: Array) -> float:
    """By how much the logarithm of the amplitude may be higher within a distance of a phase.

    Amplitudes that are concave lie below their chords: where a peak is a corner, two chords
    meet above it.

    Parameters
    ----------
    distance
        Within which it may be higher [rad].
    phase
        One of the phases [rad].
    phases, values
        Ascending phases [rad], and the logarithms there.
    """
    slopes = np.diff(values) / np.diff(phases)
    at = int(np.searchsorted(phases, phase))
    near = slopes[max(at - 1, 0) : at + 1]
    rises = [0.0]
    # between the phase and its neighbour on either side
    for own, beyond, other in ((at - 1, at + 1, at + 1), (at, at - 2, at - 1)):
        if min(own, beyond) < 0 or max(own, beyond) >= slopes.size:
            continue
        turn = slopes[own] - slopes[beyond]
        if turn:
            missing = values[other] - slopes[beyond] * (phases[other] - phase) - values[at]
            rises.append(slopes[own] * missing / turn)
    return float(min(max(rises), abs(near).max(initial=0.0) * distance))
