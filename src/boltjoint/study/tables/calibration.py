"""Tables of a calibration: parameters with intervals, their correlation, and the residuals."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks

#: columns of the table of parameters, by their variables
_WORDS = ("parameter", "unit", "reason")
_COLUMNS = {
    "parameter": "parameter",
    "unit": "unit",
    "value_before": "before",
    "value": "fitted",
    "interval_low": "95_%_from",
    "interval_high": "95_%_to",
    "bound_low": "bound_from",
    "bound_high": "bound_to",
    "reason": "not_determined",
}
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
        Columns ``parameter, unit, before, fitted, 95_%_from, 95_%_to, bound_from, bound_to,
        not_determined``: the last says why a measurement does not tell a parameter, empty where it
        does; values and intervals are empty there.

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
    }
    frame = pd.DataFrame(columns)
    frame["fitted"] = frame["fitted"].where(frame["not_determined"] == "")
    return frame


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
        probability_of_size, probability_of_runs``.

    Raises
    ------
    ValueError
        If a variable is missing or of another kind.
    """
    names = _words(calibration, "curve", "curve")
    quantities = _words(calibration, "curve_quantity", "curve_quantity")
    resonances = checks.index_variable("calibration", calibration, "curve_resonance", ("curve",))
    of_point = checks.index_variable("calibration", calibration, "curve_of_point", ("point",))
    found = {key: _numbers(calibration, key, "curve", "curve_quantity") for key in _RESIDUALS}
    return pd.DataFrame(
        [
            {
                "curve": name,
                "resonance": int(resonances[i]),
                "points": int((of_point == i).sum()),
                "quantity": quantity,
                "rms_error_percent": 100 * found["rms_error"][i, j],
                "over_stated_scatter": max(found["reduced_chi2"][i, j], 0.0) ** 0.5,
                "probability_of_size": found["size_probability"][i, j],
                "probability_of_runs": found["runs_probability"][i, j],
            }
            for i, name in enumerate(names)
            for j, quantity in enumerate(quantities)
        ]
    )


def _numbers(calibration: xr.Dataset, key: str, *dims: str) -> NDArray[np.float64]:
    return checks.variable("calibration", calibration, key, dims, finite=False)


def _words(calibration: xr.Dataset, key: str, dim: str) -> list[str]:
    """The words of a variable."""
    checks.instance("calibration", calibration, xr.Dataset)
    if key not in calibration or calibration[key].dims != (dim,):
        raise ValueError(f"calibration has no variable {key!r} over {dim}")
    return [str(each) for each in calibration[key].to_numpy()]
