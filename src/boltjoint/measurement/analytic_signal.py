"""Analytic signal of a mode in a band of frequencies: amplitude and phase without delay.

A smooth window in the spectrum leaves the mode's band and nothing at negative frequencies, so that
the inverse transform is the analytic signal ``z = a exp(i phase)`` of the mode.

References
----------
M. Feldman: Hilbert transform in vibration analysis. Mechanical Systems and Signal Processing 25
(2011) 735-802.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from boltjoint import checks
from boltjoint.measurement.signals import Signals

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

#: share of the band's width over which the window rises, and falls, by half a cosine
_TAPER = 0.25

#: samples of the analytic signal in the time of one over its bandwidth: what is between them is
#: known from them
_SAMPLES = 4

#: lag over one over the width of the band beyond which noise is not correlated
_LONGEST_LAG = 25

#: part of the record, at its end, by which the noise is told
_LAST_PART = 3

#: the transient of the band-pass, after a begin or an end of the record, over one over the width
TRANSIENT = 1.5


@dataclass(frozen=True)
class AnalyticSignal:
    """The analytic signal of a sensor in a band.

    Parameters
    ----------
    fine_time
        Equally spaced [s], shape (samples,).
    fine_values
        a exp(i phase), shape (samples,).
    band
        Lowest and highest frequency [Hz].
    """

    fine_time: Array
    fine_values: ComplexArray
    band: tuple[float, float]

    @property
    def time(self) -> Array:
        """Times by as many samples as the width of the band needs."""
        return self.fine_time[:: self._every]

    @property
    def values(self) -> ComplexArray:
        """The signal at ``time``."""
        return self.fine_values[:: self._every]

    @property
    def _every(self) -> int:
        step = self.fine_time[1] - self.fine_time[0]
        return max(1, int(1 / (step * _SAMPLES * (self.band[1] - self.band[0]))))

    @property
    def transient(self) -> float:
        """Transient of the band-pass after the begin, and before the end [s]."""
        return TRANSIENT / (self.band[1] - self.band[0])

    def correlation(self, lag: Array) -> ComplexArray:
        """Autocorrelation of white noise behind the band-pass, relative to its variance."""
        middle, width = sum(self.band) / 2, self.band[1] - self.band[0]
        envelope = np.interp(width * abs(lag), *_envelope(), right=0.0)
        return np.exp(2j * np.pi * middle * lag) * envelope


def analytic_signal(signals: Signals, band: tuple[float, float], sensor: str) -> AnalyticSignal:
    """The analytic signal of one sensor in a band.

    Parameters
    ----------
    signals
        Measured.
    band
        Lowest and highest frequency of the mode [Hz].
    sensor
        Its name.

    Raises
    ------
    ValueError
        If the band reaches beyond half of the sampling rate, or the record is shorter than four
        transients of the band-pass.
    """
    checks.instance("signals", signals, Signals)
    low, high = band = checks.interval("band", band)
    rate = signals.sampling_rate
    if high > rate / 2:
        raise ValueError(
            f"band reaches to {high:g} Hz: the record of {rate:g} samples a second "
            f"holds frequencies up to {rate / 2:g} Hz"
        )
    duration = signals.time[-1] - signals.time[0]
    if duration * (high - low) < 4 * TRANSIENT:
        raise ValueError(
            f"band is {high - low:g} Hz wide: a record of {duration:g} s needs at least "
            f"{4 * TRANSIENT / duration:.3g} Hz"
        )
    values = signals.of([sensor]).values[:, 0]
    # as long again with zeros: the end does not run into the begin
    length = 2 * values.size
    spectrum = np.fft.fft(values - values.mean(), length)
    frequency = np.asarray(np.fft.fftfreq(length, 1 / rate), dtype=float)
    z = np.fft.ifft(2 * spectrum * _window(frequency, band))[: values.size]
    return AnalyticSignal(signals.time, z, band)


def noise_level(signals: Signals, band: tuple[float, float], sensor: str) -> float:
    """Standard deviation of the noise of the analytic signal, by the spectrum beside its band.

    The median of the power in as much again on both sides, of the last part of the record: modes
    are few there, and have decayed.
    """
    low, high = band
    values = signals.of([sensor]).values[:, 0]
    count = max(values.size // _LAST_PART, 64)
    last = values[-count:]
    taper = np.hanning(last.size)
    power = abs(np.fft.rfft(taper * (last - last.mean()))) ** 2
    frequency = np.fft.rfftfreq(last.size, 1 / signals.sampling_rate)
    width = high - low
    beside = (abs(frequency - (low + high) / 2) < 1.5 * width) & (
        (frequency < low) | (frequency > high)
    )
    of_sample = np.median(power[beside]) / np.log(2) / np.sum(taper**2)
    grid = np.linspace(low, high, 129)
    passed = np.mean(_window(grid, band) ** 2) * width / signals.sampling_rate
    return float(np.sqrt(4 * of_sample * passed))


@cache
def _envelope() -> tuple[Array, Array]:
    """Correlation of noise behind the window, of width 1 around 0, by the lag."""
    frequency, lag = np.linspace(-0.5, 0.5, 257), np.linspace(0.0, _LONGEST_LAG, 100 * _LONGEST_LAG)
    power = _window(frequency, (-0.5, 0.5)) ** 2
    return lag, np.cos(2 * np.pi * np.outer(lag, frequency)) @ (power / power.sum())


def _window(frequency: Array, band: tuple[float, float]) -> Array:
    """The window in the spectrum: 1 in the middle of the band, half a cosine at its ends."""
    low, high = band
    taper = _TAPER * (high - low)
    inside = np.clip(np.minimum(frequency - low, high - frequency) / taper, 1e-3, 1 - 1e-3)
    return expit(1 / (1 - inside) - 1 / inside)
