"""Whether a model can be right: its residuals beside the stated scatter of a measurement.

References
----------
A. Wald, J. Wolfowitz: On a test whether two samples are from the same population. Annals of
Mathematical Statistics 11 (1940) 147-162.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

from boltjoint.calibration.measured_backbone import MeasuredBackbone, Measurement
from boltjoint.measurement.signals import MOTIONS

Array = NDArray[np.float64]

#: probability below which a residual is no chance
_LEAST_PROBABILITY = 1e-3

#: standard deviations by which a curve must rise to be said to
_RISE = 4.0


@dataclass(frozen=True)
class CurveCheck:
    """What speaks against a model of one curve, by its quantities: frequency and damping.

    Attributes
    ----------
    reduced_chi2
        Mean square of the residuals, in standard deviations.
    size_probability
        Of residuals so large, if the stated deviations hold.
    runs_probability
        Of so few changes of sign along the curve.
    stiffens
        Whether the measured frequency rises with the amplitude, which friction cannot make.
    loses_damping
        Whether the measured damping falls faster than that of full slip, and that of the model not.
    sentences
        What speaks against it, in words.
    """

    name: str
    reduced_chi2: tuple[float, ...]
    size_probability: tuple[float, ...]
    runs_probability: tuple[float, ...]
    stiffens: bool
    loses_damping: bool
    sentences: tuple[str, ...]


def check_curve(curve: Measurement, model: Array) -> CurveCheck:
    """Compare the residuals of a curve with its stated scatter.

    Parameters
    ----------
    curve
        Measured.
    model
        Values at its points, (points, quantities).
    """
    residuals = (curve.difference(model) / curve.deviations).T
    of_size = tuple(map(_size_probability, residuals))
    of_runs = tuple(map(runs_probability, residuals))
    mean_square = tuple(np.mean(residuals**2, axis=1).tolist())
    along = "the amplitude" if isinstance(curve, MeasuredBackbone) else "the points"
    sentences = []
    for word, square, size, runs in zip(
        curve.quantities, mean_square, of_size, of_runs, strict=True
    ):
        if size < _LEAST_PROBABILITY:
            times = f"{float(f'{np.sqrt(square):.2g}'):g}"
            sentences.append(f"{curve.name}: the {word} is off by {times} times its stated scatter")
        if runs < _LEAST_PROBABILITY:
            sentences.append(
                f"{curve.name}: the {word} errs on one side over long ranges of {along}"
            )
    rise = stiffening(curve) if isinstance(curve, MeasuredBackbone) else None
    if rise is not None:
        sentences.append(
            f"{curve.name}: the frequency rises by {rise[1]:.3g} Hz from the amplitude "
            f"{rise[0]:.3g} on; friction only softens a joint"
        )
    fall = losing_damping(curve, model) if isinstance(curve, MeasuredBackbone) else None
    if fall is not None:
        sentences.append(
            f"{curve.name}: from the amplitude {fall[0]:.3g} on the damping falls by "
            f"{100 * fall[1]:.2g} % more than over the amplitude, as in full slip; that of the "
            "joint does not"
        )
    return CurveCheck(
        curve.name,
        mean_square,
        of_size,
        of_runs,
        rise is not None,
        fall is not None,
        tuple(sentences),
    )


def _size_probability(residual: Array) -> float:
    """Probability of residuals so large, in standard deviations."""
    return float(chi2.sf(residual @ residual, residual.size))


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
    f, deviation = curve.frequency, curve.deviations[:, 0]
    lowest = int(np.argmin(f))
    rise = f[-1] - f[lowest]
    if rise > _RISE * np.hypot(deviation[-1], deviation[lowest]):
        return float(curve.amplitude[lowest]), float(rise)
    return None


def losing_damping(curve: MeasuredBackbone, model: Array) -> tuple[float, float] | None:
    """Amplitude from which the damping falls faster than in full slip, and by how much of it.

    The work of a slider under constant normal load is a convex function of the amplitude, and so is
    that of many: over the amplitude, as ``zeta f**2 a`` of displacements, it never falls. None
    where it does not, or where that of the model does so too.

    Parameters
    ----------
    curve, model
        As for ``check_curve``.
    """
    a, (f, zeta) = curve.amplitude, curve.values.T
    # accelerations have the square of the frequency in them
    power = 2 - MOTIONS.get(curve.quantity, 0)
    measured, modelled = a * f**power * zeta, a * model[:, 0] ** power * model[:, 1]
    highest = int(np.argmax(measured))
    fall = 1 - measured[-1] / measured[highest]
    relative = curve.deviations[[highest, -1]] / curve.values[[highest, -1]]
    scatter = np.hypot(power * relative[:, 0], relative[:, 1])
    of_model = 1 - modelled[-1] / modelled[highest]
    if fall > _RISE * np.linalg.norm(scatter) and of_model < fall / 20:
        return float(a[highest]), float(fall)
    return None
