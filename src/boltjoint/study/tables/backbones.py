"""Tables of backbones: the power law of microslip, and a calibration with its residuals.

In microslip the dissipation in a period grows with a power of the amplitude, a straight line in
logarithmic axes. The power is 3 for two spheres or cylinders pressed together, and ``3 + chi`` for
an Iwan element, ``-1 < chi <= 0``; measured joints have 2 to 3. In macroslip it is 1.

References
----------
R. D. Mindlin, H. Deresiewicz: Elastic spheres in contact under varying oblique forces. Journal of
Applied Mechanics 20 (1953) 327-344.
D. J. Segalman: A four-parameter Iwan model for lap-type joints. Journal of Applied Mechanics 72
(2005) 752-760.
M. R. W. Brake (ed.): The Mechanics of Jointed Structures. Springer, 2018.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.calibration.posterior_draws import LARGEST_PARETO_K
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import energy_per_period, motion_at_peak
from boltjoint.joint.model import Joint
from boltjoint.options import Options


@dataclass(frozen=True)
class MicroslipOptions(Options):
    """Range of amplitudes in which the power law is fitted, and points in it.

    The damping ratio by friction rises in microslip, is largest where macroslip begins, and falls
    beyond. The range lies below that maximum.

    Parameters
    ----------
    from_share, to_share
        That ratio at its ends, over the maximum. Below the first, single pairs slip and the curve
        has steps; above the second it bends towards macroslip. In the cases of the default study
        twice or half of either moves the power by at most 0.26 in ``enriched-40``, and by 0.49 in
        ``free-4``, whose range is less than a decade.
    points
        Points of the fit, evenly spaced over the logarithm of the amplitude. Twice or half as many
        move the power by at most 5e-3.
    """

    from_share: float = 0.01
    to_share: float = 0.1
    points: int = 200


def tabulate_microslip(
    backbones: Mapping[str, xr.Dataset], options: MicroslipOptions | None = None
) -> pd.DataFrame:
    """The power law of microslip, and where macroslip begins, of each joint.

    Parameters
    ----------
    backbones
        ``backbone.nc`` by the joint's name.
    options
        Range and points of the fit.

    Returns
    -------
    DataFrame
        A row for each joint: ``power``, the slope of the friction dissipation over the amplitude of
        the output point in logarithmic axes; the range ``from_amplitude_mm`` to
        ``to_amplitude_mm`` of the fit; ``dissipation_at_end_J``, by the fit; ``rms_error_percent``,
        the root-mean-square of the dissipation's logarithm less the line's; the largest friction
        damping ratio and its amplitude; the natural frequencies of the stuck joint and at that
        amplitude. Empty where friction dissipates nothing, or the range has fewer than two
        states.
    """
    options = MicroslipOptions() if options is None else options
    return pd.DataFrame(
        [{"joint": name, **_fit(backbone, options)} for name, backbone in backbones.items()]
    )


def peak_dissipation(
    joint: Joint, response: xr.Dataset
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Amplitude [m], frequency [Hz] and friction dissipation [J] at the peaks of responses.

    Parameters
    ----------
    joint
        That was solved.
    response
        Its ``response.nc``; forces whose branch is not complete are left out.

    Returns
    -------
    tuple of ndarray
        Each of shape (complete forces,).
    """
    balance = HarmonicBalance(joint, 0.0, 0.0)
    at = response.isel(force=np.flatnonzero(response["complete"]))
    friction = []
    for force in at["force_level"].to_numpy():
        at_peak = motion_at_peak(response, force)
        if at_peak is None:
            raise ValueError(f"the response to {force:g} has no solution")
        frequency, motion = at_peak
        x = motion.in_components(balance.components).ravel()
        friction.append(energy_per_period(balance, x, 2 * np.pi * frequency)[2])
    return at["peak_amplitude"].to_numpy(), at["peak_frequency"].to_numpy(), np.array(friction)


def _fit(backbone: xr.Dataset, options: MicroslipOptions) -> dict[str, float]:
    fit = dict.fromkeys(_COLUMNS_OF_MICROSLIP, np.nan)
    amplitude = backbone["response_amplitude"].to_numpy()
    dissipation = backbone["friction_dissipation"].to_numpy()
    frequency = backbone["natural_frequency"].to_numpy()
    damping = _friction_damping(backbone)
    if not damping.size or damping.max() <= 0:
        return fit
    top = int(damping.argmax())
    fit |= {
        "largest_friction_damping_percent": 100 * damping[top],
        "macroslip_amplitude_mm": 1e3 * amplitude[top],
        "stuck_frequency_Hz": frequency[0],
        "macroslip_frequency_Hz": frequency[top],
    }
    share = damping[: top + 1] / damping[top]
    if (ends := _range_of_microslip(np.log(amplitude[: top + 1]), share, options)) is None:
        return fit
    grid = np.linspace(*ends, options.points)
    slips = dissipation > 0
    curve = np.interp(grid, np.log(amplitude[slips]), np.log(dissipation[slips]))
    power, at_end = np.polyfit(grid - grid[-1], curve, 1)
    error = np.sqrt(np.mean((curve - at_end - power * (grid - grid[-1])) ** 2))
    return fit | {
        "power": power,
        "from_amplitude_mm": 1e3 * np.exp(ends[0]),
        "to_amplitude_mm": 1e3 * np.exp(ends[1]),
        "dissipation_at_end_J": np.exp(at_end),
        "rms_error_percent": 100 * error,
    }


def _range_of_microslip(
    x: NDArray[np.float64], share: NDArray[np.float64], options: MicroslipOptions
) -> tuple[float, float] | None:
    """Logarithms x of the amplitudes between which the damping has its shares of the maximum.

    Of several such ranges that next to the maximum, which is last; None with less than two states.
    """
    last = int(np.flatnonzero(share <= options.to_share).max(initial=-1))
    first = int(np.flatnonzero(share[: last + 1] < options.from_share).max(initial=-1)) + 1
    if last - first < 1:
        return None

    def between(before: int, value: float) -> float:
        ends = np.log(share[before : before + 2])
        return float(np.interp(np.log(value), ends, x[before : before + 2]))

    # a joint that has only just begun to slip has no curve below
    begins = first == 0 or share[first - 1] < 0.1 * options.from_share
    low = float(x[first]) if begins else between(first - 1, options.from_share)
    return low, between(last, options.to_share)


def _friction_damping(backbone: xr.Dataset) -> NDArray[np.float64]:
    """Damping ratio by friction alone, by state: ``D / (2 pi a^2 w^2)``."""
    w, a = 2 * np.pi * backbone["natural_frequency"], backbone["modal_amplitude"]
    return (backbone["friction_dissipation"] / (2 * np.pi * (a * w) ** 2)).to_numpy()


_COLUMNS_OF_MICROSLIP = (
    *("power", "from_amplitude_mm", "to_amplitude_mm", "dissipation_at_end_J", "rms_error_percent"),
    *("largest_friction_damping_percent", "macroslip_amplitude_mm"),
    *("stuck_frequency_Hz", "macroslip_frequency_Hz"),
)


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
    parts = [_residuals(calibration, "curve", "point", "")]
    if "response" in calibration:
        parts.append(_residuals(calibration, "response", "response_point", "response_"))
    rows = [row for part in parts for row in part]
    return pd.DataFrame(rows).astype({"resonance": "Int64"})


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
