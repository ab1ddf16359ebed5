"""How far the peaks of a sweep are off, as designs tell that are solved again in a larger model."""

from typing import Literal, NamedTuple

import numpy as np
import xarray as xr

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.dynamics.response.error_bars import error_bar

#: what of a peak is checked
QUANTITIES: tuple[Literal["frequency"], Literal["amplitude"]] = ("frequency", "amplitude")


def errors_of_check(solved: xr.Dataset, check: xr.Dataset) -> xr.Dataset:
    """How far the peaks of a sweep are off.

    Parameters
    ----------
    solved
        Peaks of all designs, by ``design`` and ``force``.
    check
        As from ``check_designs``.

    Returns
    -------
    Dataset
        ``checked_design``, ``checked_peak_frequency`` [Hz] and ``checked_peak_amplitude`` [m] of
        the larger model, and by ``force`` ``peak_frequency_error`` and ``peak_amplitude_error``:
        the largest of the designs that have a peak in both models, relative, with that of peaks
        that are predicted (``regression_of_peaks``); not a number without one.
        ``checked_designs`` is how many have.
    """
    at = solved.isel(design=check["checked_design"].to_numpy())
    variables, errors = {"checked_design": check["checked_design"].variable}, []
    for what in QUANTITIES:
        peak = check[f"peak_{what}_converged"].variable
        error = error_bar(check, what, at[peak_variable(solved, what)].to_numpy())
        errors.append(error)
        largest = np.where(np.isfinite(error), error, -np.inf).max(axis=0, initial=-np.inf)
        largest[np.isneginf(largest)] = np.nan
        if (regression := f"peak_{what}_regression_error") in solved:
            largest = (1 + largest) * (1 + np.nan_to_num(solved[regression].to_numpy())) - 1
        meaning = f"peak {what} of the larger model"
        row = ("checked", "force"), peak.to_numpy(), peak.attrs["units"], meaning
        variables[f"checked_peak_{what}"] = quantity(*row)
        meaning = f"largest error of the peak {what} of the checked designs"
        variables[f"peak_{what}_error"] = quantity("force", largest, "1", meaning)
    count = np.isfinite(errors).all(axis=0).sum(axis=0)
    meaning = "designs with a peak in both models"
    variables["checked_designs"] = quantity("force", count, "1", meaning)
    return xr.Dataset(variables)


class SweepError(NamedTuple):
    """How far the peaks of a sweep are off, relative, and how many designs tell it.

    ``regression`` is the error in amplitude of peaks that are predicted from others, at the level
    where the whole error is largest; None where none are predicted.
    """

    frequency: float
    amplitude: float
    designs: int
    regression: float | None

    @property
    def model(self) -> float:
        """The error in amplitude of the checked designs alone, there; both multiply."""
        return (1 + self.amplitude) / (1 + (self.regression or 0.0)) - 1


def error_of_sweep(sweep: xr.Dataset) -> SweepError | None:
    """The largest errors of a sweep at any level; None where nothing is known of them.

    Parameters
    ----------
    sweep
        ``sweep.nc``.
    """
    errors = errors_by_level(sweep)
    if errors is None or not np.isfinite([*errors.values()]).all():
        return None
    frequency, amplitude = (max(errors[what]) for what in QUANTITIES)
    regression = None
    if (name := "peak_amplitude_regression_error") in sweep:
        of_level = float(np.ravel(sweep[name])[errors["amplitude"].index(amplitude)])
        regression = of_level if np.isfinite(of_level) else None
    return SweepError(frequency, amplitude, int(np.min(sweep["checked_designs"])), regression)


def errors_by_level(sweep: xr.Dataset) -> dict[str, list[float]] | None:
    """How far frequencies and amplitudes of the peaks are off at each level; None if not checked.

    Of levels that vary there is one.

    Parameters
    ----------
    sweep
        ``sweep.nc``.
    """
    checks.instance("sweep", sweep, xr.Dataset)
    names = {what: f"peak_{what}_error" for what in QUANTITIES}
    if not set(names.values()) <= set(sweep):
        return None
    dims = ("force",) if "force" in sweep.dims else ()
    return {
        what: np.ravel(checks.variable("sweep", sweep, name, dims, finite=False)).tolist()
        for what, name in names.items()
    }


def peak_variable(sweep: xr.Dataset, what: str) -> str:
    """Name of the peak ``frequency`` or ``amplitude`` that counts: with all harmonics if known."""
    converged = f"peak_{what}_converged"
    return converged if converged in sweep else f"peak_{what}"
