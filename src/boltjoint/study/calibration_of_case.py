"""Calibration of a case: its joint fitted to its measurement, as a dataset with the answer."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.calibration.bolt_preloads import BoltPreloads, bolt_of, started
from boltjoint.calibration.calibration import Calibration
from boltjoint.calibration.fit import CalibrationOptions, fit
from boltjoint.calibration.fit_preloads import fit_preloads, loosest_bolt
from boltjoint.calibration.measured_backbone import MeasuredBackbone, Measurement
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.parameters import Parameter, Prior
from boltjoint.config.measured import Measured
from boltjoint.config.units import unit_of
from boltjoint.dataset import quantity
from boltjoint.joint.model import Joint
from boltjoint.number_format import number
from boltjoint.study.calibrated_joint import (
    CalibratedJoint,
    fitted_parameters,
    measured_curves,
)
from boltjoint.study.fitted_responses import errors_in_words, of_responses

Array = NDArray[np.float64]

#: posterior draws
_DRAWS = 200
#: amplitudes at which curves of the model are drawn
_DRAWN = 60


def calibrate(
    joint: Joint,
    case: Mapping[str, Any],
    measured: Measured,
    texts: Mapping[str, str],
    bolts: BoltPreloads | None = None,
) -> xr.Dataset:
    """Fit the joint of a case to what was measured of it.

    Parameters
    ----------
    joint, case, bolts
        As of ``CalibratedJoint``.
    measured
        What was measured, and what is fitted.
    texts
        The text of each file.

    Returns
    -------
    Dataset
        Parameters with intervals (``Calibration.interval``) and profiles, correlation, posterior
        draws with their Pareto k, curves at measured amplitudes and on a grid, responses, checks of
        the residuals, and the probability of each bolt to be the loosest where preloads are fitted;
        ``answer`` of the attributes says it in words.

    Raises
    ------
    ValueError
        If a mode is not in the model, or it cannot be solved at any start.
    """
    model = CalibratedJoint(joint, case, bolts)
    curves, units = measured_curves(measured.fitted_curves, texts)
    options = CalibrationOptions(starts=measured.starts, seed=measured.seed)
    parameters = fitted_parameters(model, measured).parameters
    calibration = _fitted(model, curves, parameters, measured.loss, options)
    draws, reliability = _draws(calibration)
    values, own = calibration.curves(), _places(calibration)
    stored = xr.Dataset(
        {
            **_of_parameters(calibration, model),
            **_of_curves(calibration, units),
            **of_points(backbones_of(curves), [values[n] for n in own]),
            **_on_grid(calibration),
            **of_responses(calibration, units, joint.excitation.unit),
            **_loosest(calibration),
            **draws,
            "cost": quantity("start", calibration.costs, "1", "half the sum of squares of a fit"),
        }
    )
    stored.attrs = {
        "condition": calibration.condition,
        "p_value": calibration.p_value,
        **reliability,
        "refusals": "\n".join(calibration.refusals),
        "loss": measured.loss,
        "calibration_options": options.stored(),
    }
    stored.attrs["answer"] = answer(stored)
    return stored


def _fitted(
    model: CalibratedJoint,
    curves: Sequence[Measurement],
    parameters: Sequence[Parameter],
    loss: str,
    options: CalibrationOptions,
) -> Calibration:
    """All parameters at once; preloads of bolts after the others, where these ended."""
    others = [parameter for parameter in parameters if bolt_of(parameter.name) is None]
    if len(others) == len(parameters):
        return fit(model, curves, parameters, loss=loss, options=options)
    begun_at = {p.name: p.start for p in parameters if p.start is not None}
    model = model.at_state(model.state_with(begun_at))
    values: dict[str, float] = {}
    if others:
        values = fit(model, curves, others, loss=loss, options=options).best_values
    begun = [
        started(parameter, values.get(parameter.name, model.value(parameter.name)))
        for parameter in parameters
    ]
    states = options.starts
    return fit_preloads(model, curves, begun, starts=states, loss=loss, options=options)


def _loosest(calibration: Calibration) -> dict[str, xr.Variable]:
    """Probability that each preload is the lowest; nothing where that means nothing."""
    if sum(bolt_of(name) is not None for name in calibration.names) < 2:
        return {}
    try:
        found = loosest_bolt(calibration)
    except ValueError:
        # the model cannot be right, or nothing depends on preloads
        return {}
    values = [found.get(name, np.nan) for name in calibration.names]
    return {
        "loosest_probability": quantity("parameter", values, "1", "that this preload is the lowest")
    }


def _of_parameters(calibration: Calibration, model: CalibratedJoint) -> dict[str, xr.Variable]:
    space, names = calibration.compared.space, list(calibration.names)
    ends = np.array(
        [
            (np.nan, np.nan) if name in calibration.undetermined else calibration.interval(name)
            for name in names
        ]
    )
    profiles = np.array([calibration.profile(name) for name in names])
    of = ("parameter", "of_parameter")
    per_key = "unit of each parameter"
    return {
        "parameter": xr.Variable("parameter", np.array(names, dtype=object)),
        "of_parameter": xr.Variable("of_parameter", np.array(names, dtype=object)),
        "unit": xr.Variable("parameter", np.array([unit_of(n).written for n in names], object)),
        "value": quantity(
            "parameter", list(calibration.best_values.values()), per_key, "at the best fit"
        ),
        "interval_low": quantity(
            "parameter", ends[:, 0], per_key, "lower end of the 95 % interval"
        ),
        "interval_high": quantity("parameter", ends[:, 1], per_key, "upper end of the same"),
        **{
            f"prior_{name}": quantity("parameter", known, per_key, f"{name} of what was known")
            for name, known in zip(Prior._fields, space.priors, strict=True)
            if not np.isnan(known).all()
        },
        "bound_low": quantity("parameter", [p.low for p in space.parameters], per_key, "bound"),
        "bound_high": quantity("parameter", [p.high for p in space.parameters], per_key, "bound"),
        "value_before": quantity(
            "parameter", [model.value(name) for name in names], per_key, "of the case"
        ),
        "is_determined": quantity(
            "parameter",
            [int(name not in calibration.undetermined) for name in names],
            "1",
            "whether the measurement tells it",
        ),
        "reason": xr.Variable(
            "parameter", np.array([calibration.reason(name) for name in names], dtype=object)
        ),
        "is_logarithmic": quantity(
            "parameter", [int(p.logarithmic) for p in space.parameters], "1", "scale"
        ),
        "covariance": quantity(of, calibration.covariance, "1", "covariance in the scales"),
        "correlation": quantity(of, calibration.correlation, "1", "correlation"),
        "profile_low": quantity(
            "parameter", profiles[:, 0], per_key, "lower end of the 95 % interval by the profile"
        ),
        "profile_high": quantity(
            "parameter", profiles[:, 1], per_key, "upper end, a bound where it does not close"
        ),
    }


def _draws(calibration: Calibration) -> tuple[dict[str, xr.Variable], dict[str, float]]:
    """Draws of the posterior with the values of all parameters, and how far they stand for it."""
    draws = calibration.draws(_DRAWS)
    space = calibration.compared.space
    values = np.array([list(space.values(scaled).values()) for scaled in draws.scaled])
    values = values.reshape(len(draws.scaled), len(calibration.names))
    drawn = quantity(("draw", "parameter"), values, "unit of each parameter", "posterior draws")
    return {"draws": drawn}, {"pareto_k": draws.pareto_k, "effective_draws": draws.effective}


def _places(calibration: Calibration) -> list[int]:
    """Places of backbones among the curves."""
    measured = calibration.compared.measured
    return [n for n, curve in enumerate(measured) if isinstance(curve, MeasuredBackbone)]


def _of_curves(calibration: Calibration, units: list[str]) -> dict[str, xr.Variable]:
    compared, own = calibration.compared, _places(calibration)
    errors, tests = calibration.rms_errors, calibration.checks_of_curves
    statistics = {
        "rms_error": (errors, "relative, root mean square"),
        "reduced_chi2": ([test.reduced_chi2 for test in tests], "mean square residual"),
        "size_probability": ([test.size_probability for test in tests], "of residuals so large"),
        "runs_probability": (
            [test.runs_probability for test in tests],
            "of so few changes of sign",
        ),
    }
    return {
        **names_of_curves(compared, [units[n] for n in own]),
        **{
            name: quantity(
                ("curve", "curve_quantity"),
                np.reshape([values[n] for n in own], (-1, 2)),
                "1",
                words,
            )
            for name, (values, words) in statistics.items()
        },
    }


def backbones_of(measured: Sequence[Measurement]) -> list[MeasuredBackbone]:
    """The backbones among measured curves."""
    return [curve for curve in measured if isinstance(curve, MeasuredBackbone)]


def names_of_curves(compared: ModelCurves, units: list[str]) -> dict[str, xr.Variable]:
    """Names of measured backbones, their modes, and quantity and unit of their amplitudes."""
    measured = backbones_of(compared.measured)
    words = {
        "curve": [curve.name for curve in measured],
        "amplitude_quantity": [curve.quantity for curve in measured],
        "amplitude_unit": units,
    }
    resonances = [number for number in compared.resonances if number is not None]
    return {
        **{
            name: xr.Variable("curve", np.array(texts, dtype=object))
            for name, texts in words.items()
        },
        "curve_quantity": xr.Variable(
            "curve_quantity", np.array(["frequency", "damping"], dtype=object)
        ),
        "curve_resonance": quantity("curve", np.array(resonances, int), "1", "number of the mode"),
    }


def of_points(
    measured: Sequence[MeasuredBackbone], curves: Sequence[Array]
) -> dict[str, xr.Variable]:
    """Measured points of all curves, and what the model has there, each (points, 2)."""
    own = np.repeat(np.arange(len(measured)), [curve.amplitude.size for curve in measured])
    model = _stacked(curves)
    return {
        "curve_of_point": quantity("point", own, "1", "place of its curve"),
        "amplitude": quantity(
            "point", _joined(measured, "amplitude"), "unit of each curve", "as measured"
        ),
        "frequency": quantity("point", _joined(measured, "frequency"), "Hz", "measured"),
        "frequency_deviation": quantity(
            "point", _joined(measured, "frequency_deviation"), "Hz", "standard deviation"
        ),
        "damping_ratio": quantity("point", _joined(measured, "damping_ratio"), "1", "measured"),
        "damping_deviation": quantity(
            "point", _joined(measured, "damping_deviation"), "1", "standard deviation"
        ),
        "model_frequency": quantity("point", model[:, 0], "Hz", "of the model"),
        "model_damping_ratio": quantity("point", model[:, 1], "1", "of the model"),
    }


def _on_grid(calibration: Calibration) -> dict[str, xr.Variable]:
    """Curves of the model, with their standard deviations by those of the parameters."""
    measured = calibration.compared.measured
    grids = [
        np.geomspace(curve.amplitude[0], curve.amplitude[-1], _DRAWN)
        if isinstance(curve, MeasuredBackbone)
        else np.asarray(curve.amplitude)
        for curve in measured
    ]
    places = _places(calibration)
    curves, bands = (
        _stacked([values[n] for n in places])
        for values in (calibration.curves(grids), calibration.bands(grids))
    )
    own = np.repeat(np.arange(len(places)), _DRAWN)
    grid = np.concatenate([np.empty(0), *(grids[n] for n in places)])
    return {
        "curve_of_grid": quantity("grid", own, "1", "place of its curve"),
        "grid_amplitude": quantity("grid", grid, "unit of each curve", "as measured"),
        "grid_frequency": quantity("grid", curves[:, 0], "Hz", "of the model"),
        "grid_frequency_deviation": quantity("grid", bands[:, 0], "Hz", "by the parameters"),
        "grid_damping_ratio": quantity("grid", curves[:, 1], "1", "of the model"),
        "grid_damping_deviation": quantity("grid", bands[:, 1], "1", "by the parameters"),
    }


def _joined(measured: Sequence[MeasuredBackbone], name: str) -> Array:
    return np.concatenate([np.empty(0), *(getattr(curve, name) for curve in measured)])


def _stacked(curves: Sequence[Array]) -> Array:
    """Frequencies and damping ratios of all curves, of none too, (points, 2)."""
    return np.concatenate([np.empty((0, 2)), *curves])


def answer(calibration: xr.Dataset) -> str:
    """What a calibration says, in sentences: what the model cannot be comes first.

    Parameters
    ----------
    calibration
        ``calibration.nc``.
    """
    refusals = calibration.attrs["refusals"].splitlines()
    sentences = [f"The model cannot be right: {'; '.join(refusals)}."] if refusals else []
    values = [
        f"{name} {_with_interval(calibration.sel(parameter=name))}"
        for name in map(str, calibration["parameter"].to_numpy())
        if calibration["is_determined"].sel(parameter=name)
    ]
    count = calibration.sizes["point"] + calibration.sizes.get("response_point", 0)
    points = f"{count} measured point{'' if count == 1 else 's'}"
    if values:
        told = ", ".join(values)
        sentences.append(f"Fitted to {points}: {told} (95 % intervals).")
    else:
        sentences.append(f"None of the parameters can be told by {points}.")
    errors = 100 * calibration["rms_error"].to_numpy()
    names = map(str, calibration["curve"].to_numpy())
    parts = [
        f"{number(f, 2)} % in frequency and {number(z, 2)} % in damping ({name})"
        for name, (f, z) in zip(names, errors, strict=True)
    ]
    parts += errors_in_words(calibration)
    sentences.append(f"The fit is off by {'; '.join(parts)}, rms.")
    parameters, reasons = (calibration[name].to_numpy() for name in ("parameter", "reason"))
    if untold := [f"{name} ({why})" for name, why in zip(parameters, reasons, strict=True) if why]:
        sentences.append(f"Cannot be told: {', '.join(untold)}.")
    if "loosest_probability" in calibration:
        probability = np.nan_to_num(calibration["loosest_probability"].to_numpy())
        name, share = parameters[np.argmax(probability)], number(100 * probability.max(), 3)
        sentences.append(f"Of the fitted preloads {name} is the lowest, by {share} % probability.")
    if not refusals:
        sentences.append("Nothing in the residuals speaks against the model.")
    return " ".join(sentences)


def _with_interval(parameter: xr.Dataset) -> str:
    value, low, high = (
        float(parameter[name]) for name in ("value", "interval_low", "interval_high")
    )
    # as many digits as tell the ends apart
    digits = max(3, 2 + math.ceil(math.log10(abs(value) / (high - low)))) if high > low else 3
    told, *ends = (number(each, min(digits, 6)) for each in (value, low, high))
    return f"{told} ({' to '.join(ends)})"
