"""The logarithm of an amplitude by the phase of its motion, near the peak.

Friction that is sampled makes amplitudes rough, so that their peak is told by parabolas of phases
that are far enough apart, and by how far the amplitudes are from smooth curves.
"""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion

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

    def widened_by(self, other: "Parabola", distance: float) -> "Parabola":
        """With a distance, and of both the flatter peak and the frequency that changes more."""
        return self._replace(
            sharpness=min(self.sharpness, other.sharpness),
            frequency_by_phase=max(self.frequency_by_phase, other.frequency_by_phase),
            distance=distance,
        )


class LocatedPeak(NamedTuple):
    """A peak of the first harmonic.

    ``frequency`` [Hz], ``motion`` and its ``phase`` [rad]; ``frequency_by_phase``, the largest
    change of ln w by the phase; ``sharpness``, minus the second derivative of ln amplitude by the
    phase: 1 at a linear resonance, less where friction makes the peak flat; ``distance`` by which
    its phase may be off [rad]: twice that of vertices, and by roughness; ``amplitude_error``,
    relative, by both; ``sampling_error`` of frequency and amplitude, relative, by the samples of
    friction, where it is estimated.
    """

    frequency: float
    motion: PeriodicMotion
    phase: float
    frequency_by_phase: float
    sharpness: float
    distance: float
    amplitude_error: float
    sampling_error: tuple[float, float] = (np.nan, np.nan)

    def frequency_error(self, frequency: float, amplitude: float, slope: float) -> float:
        """Relative error of the frequency by errors of the motion at the phase of the peak.

        Those at the phase and by the phase are independent; that by the distance is added.

        Parameters
        ----------
        frequency, amplitude
            Relative errors there.
        slope
            Error of the derivative of ln amplitude by the phase [1/rad]: over the sharpness the
            peak moves by it, or within ``sqrt(2 e / sharpness)`` of an amplitude error e.
        """
        moved = self.moved_by(amplitude, slope)
        return float(np.hypot(frequency, moved) + self.frequency_by_phase * self.distance)

    def moved_by(self, amplitude: float, slope: float) -> float:
        """Relative change of the frequency by the phase alone, as of ``frequency_error``."""
        by_amplitude = np.sqrt(2 * amplitude / self.sharpness)
        return float(self.frequency_by_phase * np.fmin(by_amplitude, slope / self.sharpness))


def deviation_from_polynomial(at: Array, values: Array) -> float:
    """Standard deviation of values from a cubic polynomial, of four from a parabola; 0 of fewer."""
    if len(at) <= 3:
        return 0.0
    degree = min(3, len(at) - 2)
    left = values - np.polyval(np.polyfit(at, values, degree), at)
    return float(np.linalg.norm(left) / np.sqrt(len(at) - degree - 1))


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
