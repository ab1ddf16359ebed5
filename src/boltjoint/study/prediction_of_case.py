"""Prediction of measured backbones that a calibration held aside, as a dataset with the answer."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.calibration.bolt_preloads import BoltPreloads
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.posterior_draws import LARGEST_PARETO_K
from boltjoint.calibration.prediction import PredictedCurve, Shift, predict_curves
from boltjoint.config.measured import Measured
from boltjoint.dataset import quantity
from boltjoint.joint.model import Joint
from boltjoint.number_format import number
from boltjoint.study.calibrated_joint import (
    CalibratedJoint,
    fitted_parameters,
    measured_curves,
)
from boltjoint.study.calibration_of_case import backbones_of, names_of_curves, of_points

Array = NDArray[np.float64]

#: changes of the frequency from the lowest to the largest amplitude
_SHIFTS = {
    "measured": "change of the frequency over the amplitude, measured",
    "predicted": "the same of the model",
    "low": "lower end of the 95 % interval of a measurement",
    "high": "upper end of the same",
}


def predict(
    joint: Joint,
    case: Mapping[str, Any],
    measured: Measured,
    texts: Mapping[str, str],
    calibration: xr.Dataset,
    bolts: BoltPreloads | None = None,
) -> xr.Dataset:
    """Predict the measured backbones of a case that were held aside from its fit.

    Parameters
    ----------
    joint, case, measured, bolts
        As of ``study.calibration_of_case.calibrate``.
    texts
        The text of each file of ``measured.predicted``.
    calibration
        ``calibration.nc``: values of the parameters, and posterior draws of them.

    Returns
    -------
    Dataset
        Measured points with predicted curves and their 95 % bands, errors, and changes of the
        frequency over the amplitude; ``answer`` of the attributes says it in words.

    Raises
    ------
    ValueError
        If a mode or a sensor is not in the model, or the calibration is of other parameters.
    """
    model = CalibratedJoint(joint, case, bolts)
    space = fitted_parameters(model, measured)
    names = [str(name) for name in calibration["parameter"].to_numpy()]
    if names != list(space.names):
        raise ValueError(f"calibration is of {', '.join(names)}, not of {', '.join(space.names)}")
    curves, units = measured_curves(measured.predicted_curves, texts)
    values = checks.variable("calibration", calibration, "value", ("parameter",))
    if bolts is not None:
        fitted = zip(names, values, strict=True)
        model = model.at_state(model.state_with(dict(fitted)))
    compared = ModelCurves(model, tuple(curves), space)
    draws = checks.variable("calibration", calibration, "draws", ("draw", "parameter"))
    drawn = np.array([space.scaled(list(draw)) for draw in draws]).reshape(draws.shape)
    predicted = predict_curves(compared, space.scaled(list(values)), drawn, measured.seed)
    stored = xr.Dataset(
        {
            **names_of_curves(compared, units),
            **of_points(backbones_of(curves), [curve.curve for curve in predicted]),
            **_bands(predicted),
            **_errors(predicted),
        },
        attrs={"pareto_k": calibration.attrs["pareto_k"], "draws": len(draws)},
    )
    stored.attrs["answer"] = answer(stored)
    return stored


def _bands(predicted: tuple[PredictedCurve, ...]) -> dict[str, xr.Variable]:
    """Ends of the 95 % intervals of measurements."""
    low, high = (np.concatenate(ends) for ends in zip(*(p.band for p in predicted), strict=True))
    return {
        f"{name}_{end}": quantity("point", values[:, n], unit, f"{word} end of the 95 % interval")
        for n, (name, unit) in enumerate((("frequency", "Hz"), ("damping_ratio", "1")))
        for end, word, values in (("low", "lower", low), ("high", "upper", high))
    }


def _errors(predicted: tuple[PredictedCurve, ...]) -> dict[str, xr.Variable]:
    """What a curve is off by, how many of its points lie in the band, and how much it shifts."""
    of = ("curve", "curve_quantity")
    shifts = np.array([p.shift for p in predicted])
    return {
        "rms_error": quantity(
            of, [p.rms_errors for p in predicted], "1", "relative, root mean square"
        ),
        "points_within": quantity(
            of, [p.points_within for p in predicted], "1", "measured points within the interval"
        ),
        "draws_reached": quantity(
            "curve", [len(p.draws) for p in predicted], "1", "posterior draws that have the mode"
        ),
        **{
            f"shift_{name}": quantity("curve", shifts[:, n], "Hz", words)
            for n, (name, words) in enumerate(_SHIFTS.items())
        },
    }


def answer(prediction: xr.Dataset) -> str:
    """What a prediction says, in sentences.

    Parameters
    ----------
    prediction
        ``prediction.nc``.
    """
    of_point, drawn = prediction["curve_of_point"].to_numpy(), prediction.attrs["draws"]
    sentences = []
    for n, name in enumerate(map(str, prediction["curve"].to_numpy())):
        curve = prediction.isel(curve=n)
        f, z = 100 * curve["rms_error"].to_numpy()
        if np.isnan(f):
            sentences.append(f"{name} cannot be predicted: the model does not reach its amplitudes")
            continue
        said = f"{name} is off by {number(f, 2)} % in frequency and {number(z, 2)} % in damping"
        reached, points = int(curve["draws_reached"]), int((of_point == n).sum())
        if reached == 0:
            sentences.append(
                f"{said} (rms), without bands: no posterior draw reaches its amplitudes"
            )
            continue
        within = " and ".join(f"{count:g}" for count in curve["points_within"].to_numpy())
        by = f" of {reached} of {drawn} draws" if reached < drawn else ""
        said += f", rms, with {within} of {points} points within the 95 % bands{by}"
        if points > 1:
            shift = {key: number(float(curve[f"shift_{key}"]), 2) for key in Shift._fields}
            said += (
                f"; its frequency shifts by {shift['predicted']} Hz ({shift['low']} to "
                f"{shift['high']} Hz) over the amplitudes, measured {shift['measured']} Hz"
            )
        sentences.append(said)
    told = f"Predicted, not fitted: {'; '.join(sentences)}."
    if (shape := prediction.attrs["pareto_k"]) > LARGEST_PARETO_K:
        told += (
            " The bands are not reliable: posterior draws do not stand for the posterior "
            f"(Pareto k {number(shape, 2) if np.isfinite(shape) else 'without limit'})."
        )
    return told
