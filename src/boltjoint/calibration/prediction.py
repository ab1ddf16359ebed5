"""Prediction of curves that were held aside from a calibration, with bands by posterior draws."""

from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.calibration.forked_map import forked_map
from boltjoint.calibration.level_path import NotReached
from boltjoint.calibration.measured_backbone import MeasuredBackbone, Measurement
from boltjoint.calibration.model_curves import ModelCurves

Array = NDArray[np.float64]

#: ends of an interval of 95 %
_ENDS = (0.025, 0.975)


class Shift(NamedTuple):
    """Change of a frequency [Hz], as measured and predicted, and ends of its 95 % interval.

    The interval is that of a measurement whose points err independently of each other.
    """

    measured: float
    predicted: float
    low: float
    high: float


@dataclass(frozen=True)
class PredictedCurve:
    """A measured curve beside the one that is predicted at its amplitudes.

    Attributes
    ----------
    measured
        As measured, (points,) amplitudes.
    resonance
        Number of the mode in the model; None of a response.
    curve
        Values at the best fit, frequency [Hz] and damping ratio of a backbone or those of
        ``MeasuredResponse.values``, shape (points, quantities); NaN where the motion is not reached
        at all amplitudes.
    draws
        The same of each posterior draw that reaches them, (draws, points, quantities).
    scatter
        ``draws`` with the stated scatter of the measurement: what would be measured.
    """

    measured: Measurement
    resonance: int | None
    curve: Array
    draws: Array
    scatter: Array

    @property
    def band(self) -> tuple[Array, Array]:
        """Ends of the 95 % interval of a measurement at each amplitude, (points, quantities)."""
        low, high = _ends(self.scatter)
        return low, high

    @property
    def points_within(self) -> tuple[int, ...]:
        """Number of measured values within their bands, by their quantities."""
        low, high = self.band
        values = self.measured.values
        return tuple(np.count_nonzero((low <= values) & (values <= high), axis=0).tolist())

    @property
    def rms_errors(self) -> tuple[float, ...]:
        """Root mean square of the errors, as of ``Calibration``."""
        return self.measured.rms_errors(self.curve)

    @property
    def shift(self) -> Shift:
        """Change of the frequency of a backbone from the lowest to the largest amplitude."""
        checks.instance("measured curve with a shift", self.measured, MeasuredBackbone)
        measured = self.measured.frequency
        low, high = _ends(self.scatter[:, -1, 0] - self.scatter[:, 0, 0])
        predicted = self.curve[-1, 0] - self.curve[0, 0]
        return Shift(float(measured[-1] - measured[0]), float(predicted), float(low), float(high))


def _ends(drawn: Array) -> Array:
    """Ends of 95 % of the draws; NaN without any."""
    return (
        np.quantile(drawn, _ENDS, axis=0) if len(drawn) else np.full((2, *drawn.shape[1:]), np.nan)
    )


def predict_curves(
    compared: ModelCurves, best: Array, drawn: Array, seed: int, processes: int = 1
) -> tuple[PredictedCurve, ...]:
    """The curves of a model with fitted parameters, and with draws of them.

    Parameters
    ----------
    compared
        Model, and measured curves that were held aside.
    best, drawn
        Parameters in their scales, at the best fit and as posterior draws, shape (parameters,) and
        (draws, parameters). Draws at which a mode is not reached are left out.
    seed
        Of the scatter of the measurement.
    processes
        Among which the draws are shared (``forked_map``).

    Raises
    ------
    ValueError
        If several processes are asked for where a process cannot be forked.
    """
    random = np.random.default_rng([seed, 1])
    # draws that were chosen several times are solved once
    different, place = np.unique(drawn, axis=0, return_inverse=True)
    predicted = []
    for measured, resonance in zip(compared.measured, compared.resonances, strict=True):
        alone = replace(compared, measured=(measured,))
        curve = _curve_at(alone, best)
        points = list(forked_map(partial(_curve_at, alone), different, processes))
        reached = [points[n] for n in place.ravel() if points[n] is not None]
        draws = np.array(reached).reshape(-1, *measured.values.shape)
        noise = random.standard_normal(draws.shape) * measured.deviations
        curve = np.full(measured.values.shape, np.nan) if curve is None else curve
        predicted.append(PredictedCurve(measured, resonance, curve, draws, draws + noise))
    return tuple(predicted)


def _curve_at(compared: ModelCurves, scaled: Array) -> Array | None:
    """The only curve of a model; None where the mode is not reached at its amplitudes."""
    try:
        ((curve, _),) = compared.curves_at(scaled, slopes=False)
    except NotReached:
        return None
    (measured,) = compared.measured
    # phases within half a turn of those measured
    return measured.values + measured.difference(curve)
