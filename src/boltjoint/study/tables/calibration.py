"""Tables of a calibration: parameters, posterior, residuals, and what it predicts."""

from collections.abc import Iterator
from itertools import product

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.calibration.posterior_draws import LARGEST_PARETO_K

#: columns of the table of parameters, by their variables
_WORDS = ("parameter", "unit", "reason")
_COLUMNS = {
    "parameter": "parameter",
    "unit": "unit",
    "value_before": "before",
    "value": "fitted",
    "interval_low": "95_%_from",
    "interval_high": "95_%_to",
    "profile_low": "profile_from",
    "profile_high": "profile_to",
    "prior_mean": "prior_mean",
    "prior_deviation": "prior_deviation",
    "bound_low": "bound_from",
    "bound_high": "bound_to",
    "reason": "not_determined",
}
_COLUMNS_OF_RESIDUALS = [
    *("curve", "resonance", "points", "quantity", "rms_error_percent", "over_stated_scatter"),
    *("probability_of_size", "probability_of_runs"),
]
_RESIDUALS = ("rms_error", "reduced_chi2", "size_probability", "runs_probability")


def tabulate_parameters(calibration: xr.Dataset) -> pd.DataFrame:
    """Fitted parameters with their intervals.

    Parameters
    ----------
    calibration
        ``calibration.nc``.

    Returns
    -------
    DataFrame
        Columns ``parameter, unit, before, fitted, 95_%_from, 95_%_to, profile_from, profile_to,
        bound_from, bound_to, not_determined``; before the bounds ``prior_mean, prior_deviation``,
        where a parameter has a prior. The last says why a measurement does not tell a
        parameter, empty where it does; values and intervals are empty there.

    Raises
    ------
    ValueError
        If a variable is missing or of another kind.
    """
    columns = {
        to: _words(calibration, name, "parameter")
        if name in _WORDS
        else _numbers(calibration, name, "parameter")
        for name, to in _COLUMNS.items()
        if not name.startswith("prior") or name in calibration
    }
    frame = pd.DataFrame(columns)
    frame["fitted"] = frame["fitted"].where(frame["not_determined"] == "")
    return frame


#: quantiles of posterior draws, by the columns of their table
_QUANTILES = {"2.5_%": 0.025, "median": 0.5, "97.5_%": 0.975}


def tabulate_posterior(calibration: xr.Dataset) -> pd.DataFrame:
    """Quantiles of the posterior draws of each parameter.

    Parameters
    ----------
    calibration
        ``calibration.nc``.

    Returns
    -------
    DataFrame
        Columns ``parameter, unit, 2.5_%, median, 97.5_%, effective_draws, pareto_k``, the last two
        of all parameters together; quantiles are empty where Pareto k is above
        ``LARGEST_PARETO_K``.

    Raises
    ------
    ValueError
        If a variable is missing or of another kind.
    """
    draws = _numbers(calibration, "draws", "draw", "parameter")
    ends = np.full((len(_QUANTILES), draws.shape[1]), np.nan)
    shape = float(calibration.attrs["pareto_k"])
    if len(draws) and shape <= LARGEST_PARETO_K:
        ends = np.quantile(draws, list(_QUANTILES.values()), axis=0)
    return pd.DataFrame(
        {
            "parameter": _words(calibration, "parameter", "parameter"),
            "unit": _words(calibration, "unit", "parameter"),
            **dict(zip(_QUANTILES, ends, strict=True)),
            "effective_draws": float(calibration.attrs["effective_draws"]),
            "pareto_k": shape,
        }
    )


def tabulate_correlation(calibration: xr.Dataset) -> pd.DataFrame:
    """Correlation of the parameters, one row each.

    Parameters
    ----------
    calibration
        ``calibration.nc``.

    Returns
    -------
    DataFrame
        Column ``parameter``, and one of each parameter.

    Raises
    ------
    ValueError
        If a variable is missing or of another kind.
    """
    names = _words(calibration, "parameter", "parameter")
    correlation = _numbers(calibration, "correlation", "parameter", "of_parameter")
    frame = pd.DataFrame(correlation, columns=names)
    frame.insert(0, "parameter", names, allow_duplicates=True)
    return frame


def tabulate_residuals(calibration: xr.Dataset) -> pd.DataFrame:
    """Residuals of each curve, and whether the model can be right.

    Parameters
    ----------
    calibration
        ``calibration.nc``.

    Returns
    -------
    DataFrame
        Columns ``curve, resonance, points, quantity, rms_error_percent, over_stated_scatter,
        probability_of_size, probability_of_runs``; resonances of responses are empty.

    Raises
    ------
    ValueError
        If a variable is missing or of another kind.
    """
    checks.instance("calibration", calibration, xr.Dataset)
    parts = [_residuals(calibration, "curve", "point", "")]
    if "response" in calibration:
        parts.append(_residuals(calibration, "response", "response_point", "response_"))
    rows = [row for part in parts for row in part]
    return pd.DataFrame(rows, columns=_COLUMNS_OF_RESIDUALS).astype({"resonance": "Int64"})


def _residuals(
    calibration: xr.Dataset, of: str, point: str, prefix: str
) -> Iterator[dict[str, object]]:
    """Rows of backbones, or of responses: of quantities that are compared."""
    names, quantities = (_words(calibration, key, key) for key in (of, f"{of}_quantity"))
    resonances: list[int | None] = [None] * len(names)
    if of == "curve":
        key = "curve_resonance"
        resonances = checks.index_variable("calibration", calibration, key, ("curve",)).tolist()
    of_point = checks.index_variable("calibration", calibration, f"{of}_of_point", (point,))
    statistics = {
        key: _numbers(calibration, f"{prefix}{key}", of, f"{of}_quantity") for key in _RESIDUALS
    }
    for (i, name), (j, quantity) in product(enumerate(names), enumerate(quantities)):
        error = statistics["rms_error"][i, j]
        if np.isnan(error):
            continue
        yield {
            "curve": name,
            "resonance": resonances[i],
            "points": int((of_point == i).sum()),
            "quantity": "phase, of 1 rad" if quantity == "phase" else quantity,
            "rms_error_percent": 100 * error,
            "over_stated_scatter": max(statistics["reduced_chi2"][i, j], 0.0) ** 0.5,
            "probability_of_size": statistics["size_probability"][i, j],
            "probability_of_runs": statistics["runs_probability"][i, j],
        }


def tabulate_prediction(prediction: xr.Dataset) -> pd.DataFrame:
    """Curves that were held aside from a fit, beside what it predicts, one row each.

    Parameters
    ----------
    prediction
        ``prediction.nc``.

    Returns
    -------
    DataFrame
        Columns ``curve, resonance, points, frequency_error_percent, damping_error_percent,
        frequency_in_band, damping_in_band, shift_measured_Hz, shift_predicted_Hz, shift_from_Hz,
        shift_to_Hz``. Errors are root mean squares. They are empty where the model does not reach
        the amplitudes.

    Raises
    ------
    ValueError
        If a variable is missing or of another kind.
    """
    what, of = "prediction", ("curve", "curve_quantity")
    quantities = _words(prediction, "curve_quantity", of[1], what)
    if quantities != ["frequency", "damping"]:
        raise ValueError(f"curve_quantity of prediction is {quantities}: not frequency and damping")
    errors = 100 * _numbers(prediction, "rms_error", *of, what=what)
    within = _numbers(prediction, "points_within", *of, what=what)
    of_point = checks.index_variable(what, prediction, "curve_of_point", ("point",))
    names = _words(prediction, "curve", "curve", what)
    shifts = {"measured": "measured", "predicted": "predicted", "low": "from", "high": "to"}
    return pd.DataFrame(
        {
            "curve": names,
            "resonance": checks.index_variable(what, prediction, "curve_resonance", ("curve",)),
            "points": np.bincount(of_point, minlength=len(names)),
            "frequency_error_percent": errors[:, 0],
            "damping_error_percent": errors[:, 1],
            "frequency_in_band": within[:, 0].astype(int),
            "damping_in_band": within[:, 1].astype(int),
            **{
                f"shift_{to}_Hz": _numbers(prediction, f"shift_{name}", "curve", what=what)
                for name, to in shifts.items()
            },
        }
    )


def _numbers(
    stored: xr.Dataset, key: str, *dims: str, what: str = "calibration"
) -> NDArray[np.float64]:
    return checks.variable(what, stored, key, dims, finite=False)


def _words(stored: xr.Dataset, key: str, dim: str, what: str = "calibration") -> list[str]:
    """The words of a variable."""
    checks.instance(what, stored, xr.Dataset)
    if key not in stored or stored[key].dims != (dim,):
        raise ValueError(f"{what} has no variable {key!r} over {dim}")
    return [str(text) for text in stored[key].to_numpy()]
