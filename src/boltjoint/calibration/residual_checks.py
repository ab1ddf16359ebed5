"""Whether a model can be right: size and order of residuals, and what friction cannot do.

References
----------
A. Wald, J. Wolfowitz: On a test whether two samples are from the same population. Annals of
Mathematical Statistics 11 (1940) 147-162.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

from boltjoint.calibration.measured_backbone import MeasuredBackbone

Array = NDArray[np.float64]

#: probability below which a residual is no chance
_LEAST_PROBABILITY = 1e-3

#: standard deviations by which a curve must rise to be said to
_RISE = 4.0


@dataclass(frozen=True)
class CurveCheck:
    """What speaks against a model of one curve.

    Attributes
    ----------
    reduced_chi2
        Mean square of the residuals of frequency and damping, in standard deviations.
    size_probability
        Of residuals so large, if the stated deviations hold, of both.
    runs_probability
        Of so few changes of sign over the amplitude, of both.
    stiffens
        Whether the measured frequency rises with the amplitude, which friction cannot make.
    sentences
        What speaks against it, in words.
    """

    name: str
    reduced_chi2: tuple[float, float]
    size_probability: tuple[float, float]
    runs_probability: tuple[float, float]
    stiffens: bool
    sentences: tuple[str, ...]


def check_curve(curve: MeasuredBackbone, model: Array) -> CurveCheck:
    """Compare the residuals of a curve with its stated scatter.

    Parameters
    ----------
    curve
        Measured.
    model
        Frequency [Hz] and damping ratio at its amplitudes, (points, 2).
    """
    pairs = (
        (model[:, 0] - curve.frequency) / curve.frequency_deviation,
        (model[:, 1] - curve.damping_ratio) / curve.damping_deviation,
    )
    of_size = [float(chi2.sf(r @ r, r.size)) for r in pairs]
    of_runs = [runs_probability(r) for r in pairs]
    mean_square = [float(np.mean(r**2)) for r in pairs]
    sentences = []
    for word, square, size, runs in zip(
        ("frequency", "damping"), mean_square, of_size, of_runs, strict=True
    ):
        if size < _LEAST_PROBABILITY:
            times = f"{float(f'{np.sqrt(square):.2g}'):g}"
            sentences.append(f"{curve.name}: the {word} is off by {times} times its stated scatter")
        if runs < _LEAST_PROBABILITY:
            sentences.append(
                f"{curve.name}: the {word} errs on one side over long ranges of the amplitude"
            )
    rise = stiffening(curve)
    if rise is not None:
        sentences.append(
            f"{curve.name}: the frequency rises by {rise[1]:.3g} Hz from the amplitude "
            f"{rise[0]:.3g} on; friction only softens a joint"
        )
    return CurveCheck(
        curve.name,
        tuple(mean_square),
        tuple(of_size),
        tuple(of_runs),
        rise is not None,
        tuple(sentences),
    )


def runs_probability(residual: Array) -> float:
    """Probability of so few runs of one sign, by the test of Wald and Wolfowitz."""
    sign = residual > 0
    n, above = sign.size, int(sign.sum())
    below = n - above
    if n < 8:
        return 1.0
    if above == 0 or below == 0:
        return float(2.0 ** (1 - n))
    runs = 1 + int(np.count_nonzero(np.diff(sign)))
    mean = 1 + 2 * above * below / n
    variance = (mean - 1) * (mean - 2) / (n - 1)
    return float(norm.cdf((runs + 0.5 - mean) / np.sqrt(variance)))


def stiffening(curve: MeasuredBackbone) -> tuple[float, float] | None:
    """Amplitude from which the measured frequency rises, and by how much [Hz]; None if it falls."""
    f, deviation = curve.frequency, curve.frequency_deviation
    lowest = int(np.argmin(f))
    rise = f[-1] - f[lowest]
    if rise > _RISE * np.hypot(deviation[-1], deviation[lowest]):
        return float(curve.amplitude[lowest]), float(rise)
    return None
