"""Error of a sweep: how far the peaks of designs are off that a larger model solved again.

The larger model has all harmonics, and its own truncation errors count to the error.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from boltjoint import checks
from boltjoint.dataset import quantity

#: what of a peak is checked
_QUANTITIES = ("frequency", "amplitude")


def errors_of_check(solved: xr.Dataset, check: xr.Dataset) -> xr.Dataset:
    """How far the peaks of a sweep are off.

    Parameters
    ----------
    solved
        Peaks of all designs, by ``design`` and ``force``.
    check
        As from ``sweeps.check_designs``.

    Returns
    -------
    Dataset
        ``checked_design``, ``checked_peak_frequency`` [Hz] and ``checked_peak_amplitude`` [m] of
        the larger model, and by ``force`` ``peak_frequency_error`` and ``peak_amplitude_error``:
        the largest of the designs that have a peak in both models, relative; not a number without
        one. ``checked_designs`` is how many have.
    """
    variables = {"checked_design": check["checked_design"].variable}
    at = solved.isel(design=check["checked_design"].to_numpy())
    for what in _QUANTITIES:
        peak = check[f"peak_{what}_converged"].to_numpy()
        bar = 1 + check[f"peak_{what}_truncation_error"].to_numpy()
        ratio = at[f"peak_{what}{_kind(solved)}"].to_numpy() / peak
        error = np.maximum(ratio, 1 / ratio) * bar - 1
        has_both = np.isfinite(error)
        largest = np.where(has_both, error, -np.inf).max(axis=0, initial=-np.inf)
        largest[np.isneginf(largest)] = np.nan
        unit = check[f"peak_{what}_converged"].attrs["units"]
        of_larger = "of the larger model, with all harmonics"
        variables[f"checked_peak_{what}"] = quantity(
            ("checked", "force"), peak, unit, f"peak {what} {of_larger}"
        )
        variables[f"peak_{what}_error"] = quantity(
            "force", largest, "1", f"largest error of the peak {what} of the checked designs"
        )
        variables["checked_designs"] = quantity(
            "force", has_both.sum(axis=0), "1", "designs with a peak in both models"
        )
    return xr.Dataset(variables)


class SweepError(NamedTuple):
    """How far the peaks of a sweep are off, relative, and how many designs tell it."""

    frequency: float
    amplitude: float
    designs: int


def error_of_sweep(sweep: xr.Dataset) -> SweepError | None:
    """The largest errors of a sweep at any level; None where nothing is known of them.

    Parameters
    ----------
    sweep
        ``sweep.nc``.
    """
    checks.instance("sweep", sweep, xr.Dataset)
    if "peak_frequency_error" not in sweep:
        return None
    errors = [np.ravel(sweep[f"peak_{what}_error"].to_numpy()) for what in _QUANTITIES]
    if not all(np.isfinite(each).all() for each in errors):
        return None
    frequency, amplitude = (float(each.max()) for each in errors)
    return SweepError(frequency, amplitude, int(np.min(sweep["checked_designs"])))


def has_all_harmonics(sweep: xr.Dataset) -> bool:
    """Whether the peaks of a sweep are those with all harmonics."""
    return "peak_frequency_converged" in sweep


def peak_variable(sweep: xr.Dataset, what: str) -> str:
    """Name of the peak ``frequency`` or ``amplitude`` that counts: with all harmonics if known."""
    return f"peak_{what}{_kind(sweep)}"


def _kind(sweep: xr.Dataset) -> str:
    return "_converged" if has_all_harmonics(sweep) else ""
