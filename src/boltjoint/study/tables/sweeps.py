"""Tables of sweeps: statistics of the peaks of all designs, and their means at the ends of keys.

Sobol indices have a module of their own, ``sobol_indices``.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.study.designs import places_of, varied
from boltjoint.study.errors_of_sweep import errors_by_level, peak_variable

#: what is told of each design and level, by the columns of the tables, and the factor of its unit
_OBSERVED = {"peak_frequency_Hz": ("frequency", 1.0), "peak_mm": ("amplitude", 1e3)}
#: shares of the designs below the columns of the statistics
_SHARES = {"p05": 0.05, "median": 0.5, "p95": 0.95}
#: share of the designs at each end of a key, and half width of an interval of 95 % over the error
_END, _HALF_WIDTH = 0.1, 1.96


def tabulate_statistics(sweep: xr.Dataset) -> pd.DataFrame:
    """Statistics of the peaks of a sweep.

    Parameters
    ----------
    sweep
        ``sweep.nc``.

    Returns
    -------
    DataFrame
        A row for each observed quantity and level (of all levels together where they vary): number
        of designs, how many have a peak, and mean, standard deviation and quantiles of these; how
        far they are off, empty where no design was solved again. Of a Saltelli design only its two
        samples count, which have the distributions of the keys.
    """
    rows = []
    places_of(sweep)
    of_levels = errors_by_level(sweep)
    errors = {
        column: iter((of_levels or {})[what])
        for column, (what, _) in _OBSERVED.items()
        if of_levels
    }
    count = drawn_designs(sweep)
    for name, level, values in peaks_by_level(sweep):
        values = values[:count]
        finite = values[np.isfinite(values)]
        row = {"observed": name, **level, "designs": values.size, "with_peak": finite.size}
        quantiles = dict.fromkeys(_SHARES, np.nan)
        mean = deviation = np.nan
        if finite.size:
            quantiles = dict(zip(_SHARES, np.quantile(finite, [*_SHARES.values()]), strict=True))
            mean, deviation = finite.mean(), finite.std()
        error = 100 * next(errors[name]) if errors else np.nan
        row |= {"mean": mean, "standard_deviation": deviation} | quantiles
        rows.append(row | {"error_percent": error})
    return pd.DataFrame(rows)


def tabulate_extremes(sweep: xr.Dataset) -> pd.DataFrame:
    """Means of the peaks at the low and the high end of each key, whatever the others are.

    The low end of a key is the tenth of the designs with its lowest values, the high end that with
    its highest; designs of equal values stay together, and those without any peak do not count.
    Where most designs share a value, the ends are its lowest and its highest value alone. In all
    designs but tables the keys vary independently of each other, so these are conditional means:
    what the others do cancels, but for the error of the sample.

    Parameters
    ----------
    sweep
        ``sweep.nc``.

    Returns
    -------
    DataFrame
        A row for each observed quantity, level and key that varies: mean over all designs that have
        a peak, and of each end the value of the key that bounds it, the number of designs, their
        mean, and the half width of its interval of 95 % if they were drawn at random. A grid is not
        drawn: its half widths are zero. Of a Saltelli design only its two samples count.
    """
    count, drawn = drawn_designs(sweep), "design" in sweep.dims
    peaks = [(name, level, values[:count]) for name, level, values in peaks_by_level(sweep)]
    solved = np.any([np.isfinite(values) for _, _, values in peaks], axis=0)
    ends = {
        key: _ends(of_key.to_numpy()[:count], solved)
        for key, of_key in values_of_keys(sweep).items()
        if solved.any()
    }
    rows = []
    for name, level, values in peaks:
        finite = values[np.isfinite(values)]
        mean = finite.mean() if finite.size else np.nan
        for key, ends_of_key in ends.items():
            row = {"observed": name, **level, "key": key, "unit": sweep[key].attrs["units"]}
            row["mean"] = mean
            for end, (bound, inside) in ends_of_key.items():
                told = {"bound": bound} | _mean_with_interval(values[inside], drawn)
                row |= {f"{end}_{of}": value for of, value in told.items()}
            rows.append(row)
    return pd.DataFrame(rows, columns=[*rows[0]] if rows else ["observed", "key"])


def drawn_designs(sweep: xr.Dataset) -> int:
    """Number of designs, from the first, that have the distributions of the keys."""
    places_of(sweep)
    if "saltelli_samples" not in sweep.attrs:
        return sweep["reason"].size
    samples = checks.whole("saltelli_samples", sweep.attrs["saltelli_samples"], at_least=1)
    if (expected := samples * (len(varied(sweep)) + 2)) != sweep["reason"].size:
        raise ValueError(f"there are {sweep['reason'].size} designs, but {expected} are asked for")
    return 2 * samples


def values_of_keys(sweep: xr.Dataset) -> dict[str, xr.DataArray]:
    """Values of each key that varies, one design after another; none that has one value only.

    Lengths are in mm, as in the configuration.
    """
    by_key = {}
    for name in varied(sweep):
        whole, _ = xr.broadcast(sweep[name], sweep["reason"])
        # in the order in which the peaks are, whichever dimension the key has
        values = whole.transpose(*sweep["reason"].dims).to_numpy().ravel()
        if values.size and np.ptp(values) > 0:
            attributes = dict(sweep[name].attrs)
            if attributes["units"] == "m":
                values, attributes["units"] = 1e3 * values, "mm"
            by_key[name] = xr.DataArray(values, dims="design", attrs=attributes)
    return by_key


def response_quantiles(sweep: xr.Dataset, shares: Sequence[float]) -> NDArray[np.float64]:
    """Response amplitudes [m] below which shares of the designs lie, (levels, shares, frequency).

    Designs without a response do not count; where levels vary, all are one level.
    """
    dims = (*places_of(sweep), "frequency")
    levels = [level for level in ("force",) if level in sweep.dims]
    amplitude = checks.variable(
        "sweep", sweep, "response_amplitude", (*levels, *dims), finite=False
    )
    of_levels = amplitude if levels else amplitude[None]
    return np.array([_quantiles(values, shares) for values in of_levels])


def backbone_quantiles(
    sweep: xr.Dataset, name: str, shares: Sequence[float]
) -> NDArray[np.float64]:
    """Natural frequencies or damping ratios as ``response_quantiles``, (shares, amplitude)."""
    dims = (*places_of(sweep), "amplitude")
    return _quantiles(checks.variable("sweep", sweep, name, dims, finite=False), shares)


def _quantiles(values: NDArray[np.float64], shares: Sequence[float]) -> NDArray[np.float64]:
    """Quantiles over all designs at each place of a grid, which is last, (shares, grid).

    They are not numbers where no design has a value.
    """
    of_values = checks.array("shares", shares, ("shares",), at_least=0, at_most=1)
    rows = values.reshape(-1, values.shape[-1])
    quantiles = np.full((len(of_values), rows.shape[1]), np.nan)
    # no design may reach the ends of the grid
    reached = np.isfinite(rows).any(axis=0)
    if reached.any():
        quantiles[:, reached] = np.nanquantile(rows[:, reached], of_values, axis=0)
    return quantiles


def _ends(
    values: NDArray[np.float64], solved: NDArray[np.bool_]
) -> dict[str, tuple[float, NDArray[np.bool_]]]:
    """Bound of the low and of the high end of a key, and which of all designs lie there."""
    counted = values[solved]
    low = np.quantile(counted, _END, method="inverted_cdf")
    high = -np.quantile(-counted, _END, method="inverted_cdf")
    if low >= high:
        low, high = counted.min(), counted.max()
    return {
        "low": (float(low), solved & (values <= low)),
        "high": (float(high), solved & (values >= high)),
    }


def _mean_with_interval(values: NDArray[np.float64], drawn: bool) -> dict[str, float]:
    """Number of designs with a peak, their mean, and half width of its interval."""
    finite = values[np.isfinite(values)]
    mean = finite.mean() if finite.size else np.nan
    if drawn:
        error = finite.std(ddof=1) / np.sqrt(finite.size) if finite.size > 1 else np.nan
    else:
        error = 0.0
    return {"designs": finite.size, "mean": mean, "half_width": _HALF_WIDTH * error}


def peaks_by_level(
    sweep: xr.Dataset,
) -> Iterator[tuple[str, dict[str, float], NDArray[np.float64]]]:
    """Observed quantity, level and values of all designs, one after another.

    Peaks are those with all harmonics, where these were observed.
    """
    for column, (what, factor) in _OBSERVED.items():
        name, places = peak_variable(sweep, what), places_of(sweep)
        if "force" not in sweep.dims:
            values = checks.variable("sweep", sweep, name, places, finite=False)
            yield column, {}, factor * values.ravel()
            continue
        levels = checks.variable("sweep", sweep, "force_level", ("force",)).tolist()
        values = checks.variable("sweep", sweep, name, ("force", *places), finite=False)
        for level, of_level in zip(levels, values, strict=True):
            yield column, {"force_N": level}, factor * of_level.ravel()
