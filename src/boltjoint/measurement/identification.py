"""Frequency and damping of a mode over its amplitude, from the free decay of a joint; scatter.

Two methods are side by side. *Analytic signal*: phase and amplitude of the band-passed signal at
all times. *Peak finding*: its extrema alone, whose phases are multiples of pi (peak finding and
fitting). The same local least squares (``window_choice``) differentiate both.

The energy of a mode whose frequency w falls with its amplitude a is not that of a linear one. The
damping ratio of the backbone has the factor of a softening spring::

    zeta = sigma / w (1 + (1/2) d ln w / d ln a)

References
----------
M. Jin, W. Chen, M. R. W. Brake, H. Song: Identification of instantaneous frequency and damping from
transient decay data. Journal of Vibration and Acoustics 142 (2020) 051111.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.measurement.analytic_signal import AnalyticSignal, analytic_signal, noise_level
from boltjoint.measurement.signals import Signals
from boltjoint.measurement.window_choice import LocalFit, NoisyDecay, RegressionOptions

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

#: amplitudes over the largest one that the band-pass separates from its own transients
_RANGE = 1e-3

#: an amplitude that grows again by this ratio, and by as many standard deviations of its noise, is
#: the beat of two modes
_BEAT, _BEAT_ERRORS = 1.1, 5.0


@dataclass(frozen=True)
class IdentifiedMode:
    """Frequency and damping ratio over the amplitude of a sensor, with standard errors.

    Parameters
    ----------
    time
        At which the decay passes the amplitudes [s], shape (points,).
    amplitude
        Amplitude of the sensor [unit of its quantity], shape (points,).
    frequency, frequency_error
        Natural frequency and its standard error [Hz], shape (points,).
    damping_ratio, damping_error
        Modal damping ratio and its standard error [-], shape (points,).
    window
        Window of the local least squares [s], shape (points,).
    sensor, quantity, method
        What was measured, and how it was identified.
    """

    time: Array
    amplitude: Array
    frequency: Array
    frequency_error: Array
    damping_ratio: Array
    damping_error: Array
    window: Array
    sensor: str
    quantity: str
    method: str

    def __post_init__(self) -> None:
        """Refuse arrays that do not fit each other."""
        points = checks.array("time", self.time, ("points",)).shape
        for field in fields(self):
            if field.type is not str:
                checks.array(field.name, getattr(self, field.name), points)


def identify_ring_down(
    signals: Signals,
    band: tuple[float, float],
    *,
    sensor: str | None = None,
    method: str = "analytic signal",
    options: RegressionOptions | None = None,
) -> IdentifiedMode:
    """Identify one mode of a ring-down.

    Standard errors hold the noise, and what the residuals of the local least squares have beyond
    it, such as traces of other modes.

    Parameters
    ----------
    signals
        Signals of the free decay: from after the impact, or from where the shaker was switched off.
    band
        Lowest and highest frequency that hold the mode, and no other [Hz].
    sensor
        Its name; by default the first one.
    method
        ``analytic signal`` or ``peak finding``.
    options
        Options of the local least squares.

    Returns
    -------
    IdentifiedMode
        Frequency [Hz] and damping ratio over amplitude, with standard errors.

    Raises
    ------
    ValueError
        If the band is out of range or holds two modes, or nothing in it is above the noise.
    """
    checks.instance("signals", signals, Signals)
    options = RegressionOptions() if options is None else options
    checks.instance("options", options, RegressionOptions)
    samples_of = _METHODS[checks.choice("method", method, _METHODS)]
    sensor = signals.sensors[0] if sensor is None else sensor
    z = analytic_signal(signals, band, sensor)
    noise = noise_level(signals, band, sensor)
    time, log_z = samples_of(z)
    used = _usable(z, time, log_z, noise, options)
    time, log_z = time[used], log_z[used]
    _refuse_beats(z.band, log_z, noise)
    periods = np.ptp(log_z.imag) / (2 * np.pi)
    period, width = np.ptp(time) / periods, z.band[1] - z.band[0]
    shortest = max(options.shortest_window * period, options.shortest_transients / width)
    longest = max(options.longest_window * period, shortest)
    steps = np.arange(1 + np.floor(np.log(longest / shortest) / np.log(options.window_ratio)))
    windows = shortest * options.window_ratio**steps
    decay = NoisyDecay(time, log_z, noise, z.correlation)
    levels = _times(time, log_z.real, shortest, options.points)
    fits = [(at, fit) for at in levels if (fit := decay.fits(at, windows, options)) is not None]
    if not fits:
        raise ValueError(
            f"band from {band[0]:g} to {band[1]:g} Hz: the decay above the noise lasts "
            f"{np.ptp(time):.3g} s, the shortest window {shortest:.3g} s; "
            "choose a wider band, or a longer record"
        )
    return _identified(fits, options.frequency_factor, sensor, signals.quantity, method)


def _identified(
    fits: list[tuple[float, tuple[LocalFit, LocalFit]]],
    frequency_factor: float,
    sensor: str,
    quantity: str,
    method: str,
) -> IdentifiedMode:
    at = np.array([t for t, _ in fits])
    size, phase = zip(*(fit for _, fit in fits), strict=True)
    a = np.exp([fit.value for fit in size])
    sigma, sigma_error = np.array([(-fit.slope, fit.error) for fit in size]).T
    w, w_error = np.array([(fit.slope, fit.error) for fit in phase]).T
    undamped = np.hypot(w, sigma)
    factor = 1 + 0.5 * _softening(w, w_error, a)
    return IdentifiedMode(
        at,
        a,
        undamped / (2 * np.pi),
        frequency_factor * w_error / (2 * np.pi),
        sigma / undamped * factor,
        sigma_error / undamped * factor,
        np.array([fit.window for fit in phase]),
        sensor,
        quantity,
        method,
    )


def _softening(w: Array, error: Array, a: Array) -> Array:
    """Slope of ln w over ln a, by a parabola: the factor needs no more."""
    if w.size < 4:
        return np.zeros(w.size)
    x = np.log(a)
    curve = np.polynomial.Polynomial.fit(x, np.log(w), 2, w=w / np.maximum(error, 1e-9 * w))
    return curve.deriv()(x)


def _every_sample(z: AnalyticSignal) -> tuple[Array, ComplexArray]:
    """All times, and ln z there."""
    # turned back by the middle of the band, whatever turns are between two samples
    turned = np.pi * sum(z.band) * z.time
    phase = np.unwrap(np.angle(z.values * np.exp(-1j * turned))) + turned
    return z.time, np.log(abs(z.values)) + 1j * phase


def _extrema(z: AnalyticSignal) -> tuple[Array, ComplexArray]:
    """Times of the extrema of the band-passed signal, ln of their sizes and their phases."""
    time, y = z.fine_time, z.fine_values.real
    slope = np.diff(y)
    at = 1 + np.flatnonzero((slope[:-1] * slope[1:] <= 0) & (slope[:-1] != 0))
    # of the parabola through three samples
    before, here, after = y[at - 1], y[at], y[at + 1]
    bend = before - 2 * here + after
    aside = 0.5 * (before - after) / bend
    step = time[1] - time[0]
    size = abs(here - 0.25 * (before - after) * aside)
    return time[at] + aside * step, np.log(size) + 1j * np.pi * np.arange(at.size)


def _usable(
    z: AnalyticSignal, time: Array, log_z: ComplexArray, noise: float, options: RegressionOptions
) -> slice:
    """Samples between the transients, down to where the noise begins."""
    begin, end = z.time[0] + z.transient, z.time[-1] - z.transient
    inside = (time >= begin) & (time <= end)
    first = int(np.argmax(inside))
    floor = max(options.smallest_ratio * noise, _RANGE * abs(z.values).max())
    rest = np.flatnonzero((log_z.real[first:] < np.log(floor)) | ~inside[first:])
    last = first + int(rest[0]) if rest.size else time.size
    if last - first < 2 * options.phase_degree + 4:
        raise ValueError(
            f"band from {z.band[0]:g} to {z.band[1]:g} Hz holds no decay above the noise: "
            f"its amplitude must exceed {floor:.3g}"
        )
    return slice(first, last)


def _refuse_beats(band: tuple[float, float], log_z: ComplexArray, noise: float) -> None:
    """Refuse an amplitude that grows again."""
    lowest = np.minimum.accumulate(log_z.real)
    margin = np.log(_BEAT) + np.log1p(_BEAT_ERRORS * noise / np.exp(lowest))
    if np.any(log_z.real > lowest + margin):
        raise ValueError(
            f"band from {band[0]:g} to {band[1]:g} Hz holds two modes: the amplitude falls and "
            "grows again; choose a narrower band, or a sensor at a node of one of them"
        )


def _times(time: Array, log_a: Array, shortest: float, points: int) -> Array:
    """Times at equal steps of ln(amplitude), as far from both ends as the shortest window needs."""
    inside = (time >= time[0] + shortest / 2) & (time <= time[-1] - shortest / 2)
    if not inside.any():
        return np.zeros(0)
    own, size = time[inside], np.minimum.accumulate(log_a[inside])
    levels = np.linspace(size[0], size[-1], points)
    return np.unique(np.interp(-levels, -size, own))


_METHODS: dict[str, Callable[[AnalyticSignal], tuple[Array, ComplexArray]]] = {
    "analytic signal": _every_sample,
    "peak finding": _extrema,
}


@dataclass(frozen=True)
class Scatter:
    """Mean of several identifications of one decay, and their scatter.

    Parameters
    ----------
    time
        Time of the decay [s], shape (points,).
    frequency, frequency_scatter
        Weighted mean, and standard deviation between them [Hz], shape (points,).
    damping_ratio, damping_scatter
        The same [-], shape (points,).
    frequency_over_error, damping_over_error
        Median over the times of the scatter over the stated standard errors: near 1 where these
        hold all of it.
    """

    time: Array
    frequency: Array
    frequency_scatter: Array
    damping_ratio: Array
    damping_scatter: Array
    frequency_over_error: float
    damping_over_error: float


def scatter_between(modes: Sequence[IdentifiedMode]) -> Scatter:
    """Scatter between identifications of one decay, by sensors or methods.

    They are compared at the times of the first that lie within all.

    Parameters
    ----------
    modes
        Two or more, of one decay.

    Raises
    ------
    ValueError
        If there are fewer, or they have no time in common.
    """
    checks.sequence("modes", modes, IdentifiedMode)
    if len(modes) < 2:
        raise ValueError(f"modes has {len(modes)}: scatter is between two at least")
    begin, end = max(m.time.min() for m in modes), min(m.time.max() for m in modes)
    time = modes[0].time[(modes[0].time >= begin) & (modes[0].time <= end)]
    if time.size == 0:
        raise ValueError("modes have no time in common")

    def at_times(name: str) -> Array:
        return np.array([np.interp(time, m.time, getattr(m, name)) for m in modes])

    of_frequency = _mean(at_times("frequency"), at_times("frequency_error"))
    of_damping = _mean(at_times("damping_ratio"), at_times("damping_error"))
    return Scatter(time, *of_frequency[:2], *of_damping[:2], of_frequency[2], of_damping[2])


def _mean(values: Array, errors: Array) -> tuple[Array, Array, float]:
    """Weighted mean, scatter, and the median of the scatter over what the errors explain."""
    weight = 1 / errors**2
    mean = (weight * values).sum(axis=0) / weight.sum(axis=0)
    scatter = values.std(axis=0, ddof=1)
    chi = (weight * (values - mean) ** 2).sum(axis=0) / (len(values) - 1)
    return mean, scatter, float(np.sqrt(np.median(chi)))
