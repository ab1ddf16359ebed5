"""Designs of a sweep that are impossible or were not solved to the end, with their reasons."""

import re

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint.report.pages.sweep.data import by_level
from boltjoint.study.tables.html import number
from boltjoint.study.tables.sweeps import values_of_keys

#: reasons in the table, from the most frequent one
_MOST = 30
_NUMBER = re.compile(r"(?<![\w.])[+-]?\d[\d.]*(?:e[+-]?\d+)?")


def tabulate_failures(sweep: xr.Dataset) -> pd.DataFrame:
    """Reasons why designs are impossible or a branch of theirs ends before.

    Parameters
    ----------
    sweep
        ``sweep.nc``.

    Returns
    -------
    DataFrame
        A row for each reason, from the most frequent one: the first design with it, how many have
        it, how many of these have a peak at every level nevertheless, and the keys of the first.
        Reasons that differ in numbers only count as one, told as of the first.
    """
    reasons = sweep["reason"].to_numpy().ravel().astype(str)
    with_peaks = np.isfinite(by_level(sweep, "peak_frequency")).all(axis=0)
    keys = values_of_keys(sweep)
    by_reason: dict[str, list[int]] = {}
    for design in np.flatnonzero(reasons != ""):
        by_reason.setdefault(_NUMBER.sub("…", reasons[design]), []).append(int(design))
    rows = [
        {
            "reason": reasons[designs[0]],
            "designs": len(designs),
            "with_peaks": int(with_peaks[designs].sum()),
            "first_design": designs[0],
            "keys_of_the_first": ", ".join(
                f"{name.replace('_', ' ')} {_with_unit(key, designs[0])}"
                for name, key in keys.items()
            ),
        }
        for designs in sorted(by_reason.values(), key=len, reverse=True)[:_MOST]
    ]
    names = ("reason", "designs", "with_peaks", "first_design", "keys_of_the_first")
    return pd.DataFrame(rows, columns=names)


def _with_unit(values: xr.DataArray, design: int) -> str:
    unit = values.attrs["units"]
    return number(float(values[design])) + ("" if unit == "1" else f" {unit}")
