"""Sobol indices of the peaks of a sweep, and their intervals by bootstrap."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint.study.designs import places_of, varied
from boltjoint.study.tables.sweeps import drawn_designs, peaks_by_level

#: confidence level of the intervals of indices, and repetitions of the sample they are found from
_CONFIDENCE, _RESAMPLES = 0.95, 499
_ORDERS = ("first_order", "total")


def tabulate_sensitivity(sweep: xr.Dataset) -> pd.DataFrame:
    """Sobol indices of the peaks of a sweep with a Saltelli design.

    Parameters
    ----------
    sweep
        ``sweep.nc``.

    Returns
    -------
    DataFrame
        A row for each observed quantity, level and key: its share in the variance by itself
        (first order) and with all others (total), with intervals of 95 %, and the designs of each
        sample that they are found from, the largest power of two of those that have all peaks.

    Raises
    ------
    ValueError
        If the design is another one.

    References
    ----------
    A. Saltelli, P. Annoni, I. Azzini, F. Campolongo, M. Ratto, S. Tarantola: Variance based
    sensitivity analysis of model output. Computer Physics Communications 181 (2010) 259-270.
    """
    places_of(sweep)
    if "saltelli_samples" not in sweep.attrs:
        raise ValueError("Sobol indices are found from designs of the kind saltelli only")
    keys, samples = varied(sweep), drawn_designs(sweep) // 2
    rows = []
    for name, level, values in peaks_by_level(sweep):
        parts = values.reshape(len(keys) + 2, samples)
        parts = parts[:, np.isfinite(parts).all(axis=0)]
        count = 1 << (parts.shape[1].bit_length() - 1) if parts.shape[1] else 0
        row = {"observed": name, **level, "samples": count}
        unknown = [f"{order}{end}" for order in _ORDERS for end in ("", "_low", "_high")]
        drawn = parts[:, :count]
        if count < 2 or np.ptp(drawn) == 0:
            rows += [row | {"key": key} | dict.fromkeys(unknown, np.nan) for key in keys]
            continue
        indices, (low, high) = _indices(drawn), _intervals(drawn)
        for place, key in enumerate(keys):
            told = {
                f"{order}{end}": values[number, place]
                for number, order in enumerate(_ORDERS)
                for end, values in (("", indices), ("_low", low), ("_high", high))
            }
            rows.append(row | {"key": key} | told)
    return pd.DataFrame(rows)


def _indices(parts: NDArray[np.float64]) -> NDArray[np.float64]:
    """First-order and total indices, (2, keys), of the designs by rows, (keys + 2, samples).

    The estimators (b) and (f) in table 2 of Saltelli et al. (2010), of values whose mean over both
    samples is zero.
    """
    both = parts[:2]
    if len(parts) == len(both) + 1:
        # all variance is that of the only key: nothing is estimated
        return np.ones((2, 1))
    first, second, *mixed = parts - both.mean()
    mixed = np.array(mixed)
    first_order = np.mean(second * (mixed - first), axis=1)
    total = np.mean((first - mixed) ** 2, axis=1) / 2
    return np.array([first_order, total]) / both.var()


def _intervals(parts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lower and upper ends of the intervals of ``_indices``, (2, 2, keys), by bootstrap."""
    random, count = np.random.default_rng(0), parts.shape[1]
    again = [_indices(parts[:, random.integers(count, size=count)]) for _ in range(_RESAMPLES)]
    outside = (1 - _CONFIDENCE) / 2
    return np.quantile(again, [outside, 1 - outside], axis=0)
