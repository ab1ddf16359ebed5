"""Slopes of phase and amplitude of a free decay by local least squares, and the choice of windows.

Near a time t0 polynomials are fitted to both parts of ``ln z = ln a + i phase`` over windows. Their
slopes at t0 are ``-sigma`` and w. The noise of ln z is that of z over z, so that samples count with
``|z|^2``.

The window is chosen at each time: the longest whose intervals of both slopes meet those of all
shorter ones (intersection of confidence intervals), since bias grows with the window and noise
falls.

References
----------
A. Goldenshluger, A. Nemirovski: On spatially adaptive estimation of nonparametric regression.
Mathematical Methods of Statistics 6 (1997) 135-170.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint.options import Options

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class RegressionOptions(Options):
    """Identification of ring-downs: windows of the local least squares, and how they are chosen.

    Parameters
    ----------
    phase_degree, amplitude_degree
        Degrees of the polynomials of phase and ln(amplitude): a softening mode bends the phase
        more. On made-up ring-downs with noise stated intervals hold most nearly as often as they
        should with 3 and 2.
    shortest_window
        Shortest length [periods].
    shortest_transients
        Shortest length over one over the width of the band: what the band-pass lets through has as
        many independent samples in it.
    window_ratio
        Window ratio of each window to the next shorter one.
    longest_window
        Longest length [periods].
    threshold
        Standard errors within which windows must agree: with more, windows are longer, errors
        smaller and intervals hold less often.
    points
        Amplitudes at which a mode is identified, at most, equally spaced in ln(amplitude).
    frequency_factor
        Standard error of the frequency over that of a window that is chosen before the record is
        seen: with it, and with none for the damping, stated 95 % intervals hold in 90 to 97 of 100
        points of made-up ring-downs with noise.
    smallest_ratio
        Amplitude over the noise below which nothing is identified.
    """

    phase_degree: int = 3
    amplitude_degree: int = 2
    shortest_window: float = 6.0
    shortest_transients: float = 8.0
    window_ratio: float = 1.4
    longest_window: float = 400.0
    threshold: float = 1.5
    points: int = 40
    frequency_factor: float = 1.15
    smallest_ratio: float = 10.0


@dataclass(frozen=True)
class LocalFit:
    """A value at a time, its slope with the standard error, and the window [s].

    The error holds what the residual of the fit has beyond the noise.
    """

    value: float
    slope: float
    error: float
    window: float


@dataclass(frozen=True)
class NoisyDecay:
    """Samples of ln z with the noise of z.

    Parameters
    ----------
    time, log_z
        Shape (samples,).
    noise
        Standard deviation of z.
    correlation
        Correlation of the noise of z by the lag [s].
    """

    time: Array
    log_z: ComplexArray
    noise: float
    correlation: Callable[[Array], ComplexArray]

    def fits(
        self, at: float, windows: Array, options: RegressionOptions
    ) -> tuple[LocalFit, LocalFit] | None:
        """Fits of ln(amplitude) and phase at a time; None with too few samples.

        Parameters
        ----------
        at
            t0 [s].
        windows
            Lengths [s], ascending.
        options
            Degrees and threshold.
        """
        degrees = options.amplitude_degree, options.phase_degree
        chosen: tuple[LocalFit, LocalFit] | None = None
        lower, upper = np.full(2, -np.inf), np.full(2, np.inf)
        for inside in self._windows(at, windows, options):
            covariance = self._covariance(inside)
            amplitude, phase = (
                _fit(at, self.time[inside], values[inside], covariance, degree)
                for values, degree in zip((self.log_z.real, self.log_z.imag), degrees, strict=True)
            )
            slope = np.array([amplitude.slope, phase.slope])
            margin = options.threshold * np.array([amplitude.error, phase.error])
            lower, upper = np.maximum(lower, slope - margin), np.minimum(upper, slope + margin)
            if chosen is not None and np.any(lower > upper):
                break
            chosen = amplitude, phase
        return chosen

    def _windows(self, at: float, windows: Array, options: RegressionOptions) -> Iterator[slice]:
        """Samples in each window around a time that lies within them all."""
        fewest = max(options.phase_degree, options.amplitude_degree) + 3
        reach = min(at - self.time[0], self.time[-1] - at)
        rounding = 1e-9 * windows[0]
        for window in windows[windows / 2 <= reach + rounding]:
            ends = np.searchsorted(self.time, [at - window / 2, at + window / 2])
            if ends[1] - ends[0] >= fewest:
                yield slice(*ends)

    def _covariance(self, inside: slice) -> Array:
        """Of the noise of either part of ln z in a window, shape (samples, samples)."""
        time, log_z = self.time[inside], self.log_z[inside]
        noise = self.noise * np.exp(-log_z.real - 1j * log_z.imag)
        lag = time[:, None] - time[None, :]
        return (np.outer(noise, noise.conj()) * self.correlation(lag)).real / 2


def _fit(at: float, time: Array, values: Array, covariance: Array, degree: int) -> LocalFit:
    """Weighted least squares of a polynomial, with the error that correlated noise makes."""
    half = (time[-1] - time[0]) / 2
    powers = ((time - at) / half)[:, None] ** np.arange(degree + 1)
    variance = np.diag(covariance)
    weight = variance.min() / variance
    estimator = np.linalg.solve(powers.T @ (weight[:, None] * powers), powers.T * weight)
    coefficients = estimator @ values
    residual = values - powers @ coefficients
    # what the noise leaves of the residual: the trace of P C P^T W with the projector P
    left = covariance - powers @ (estimator @ covariance)
    explained = weight @ np.diag(left - (left @ estimator.T) @ powers.T)
    misfit = max(1.0, float(weight @ residual**2 / explained))
    error = np.sqrt(max(estimator[1] @ covariance @ estimator[1], 0.0) * misfit) / half
    return LocalFit(float(coefficients[0]), float(coefficients[1] / half), float(error), 2 * half)
