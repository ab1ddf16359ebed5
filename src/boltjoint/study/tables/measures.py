"""Errors of peaks and curves against a reference."""

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks

#: errors of a peak, and what they are errors of
PEAK_ERRORS = {
    "peak_frequency_error_percent": "peak_frequency_Hz",
    "peak_amplitude_error_percent": "peak_mm_per_N",
}


def curve_error(
    curve: tuple[NDArray[np.float64], NDArray[np.float64]],
    reference: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> float:
    """Root-mean-square distance of two responses over frequency, in decibels.

    Where a curve is folded, its largest amplitude counts. Both are compared over the frequencies
    they share; 1 dB is a difference of 12 %.

    Parameters
    ----------
    curve, reference
        Frequency and amplitude along the branch, each of shape (solutions,).
    """
    shared = max(curve[0].min(), reference[0].min()), min(curve[0].max(), reference[0].max())
    grid = np.unique(np.concatenate([curve[0], reference[0], shared]))
    grid = grid[(grid >= shared[0]) & (grid <= shared[1])]
    level, reference_level = (
        20 * np.log10(upper_branch(*line, grid)) for line in (curve, reference)
    )
    square = np.trapezoid((level - reference_level) ** 2, grid) / (grid[-1] - grid[0])
    return float(np.sqrt(square))


def upper_branch(
    frequency: NDArray[np.float64], amplitude: NDArray[np.float64], grid: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Largest amplitude of a piecewise-linear branch at each frequency of a grid it covers."""
    before, after = frequency[:-1], frequency[1:]
    covers = (np.minimum(before, after) <= grid[:, None]) & (
        grid[:, None] <= np.maximum(before, after)
    )
    length = np.where(after == before, 1.0, after - before)
    share = (grid[:, None] - before) / length
    value = amplitude[:-1] + share * (amplitude[1:] - amplitude[:-1])
    return np.where(covers, value, -np.inf).max(axis=1)


def peak_of_level(response: xr.Dataset, level: int) -> dict[str, Any]:
    """Solutions, completeness and peak of a force level."""
    levels = checks.variable("response", response, "force_level", ("force",))
    level = checks.whole("level", level, at_least=0, below=len(levels))
    at = response.isel(force=level)
    force = float(at["force_level"])
    return {
        "solutions": int((response["excitation_force"] == force).sum()),
        "complete": bool(at["complete"]),
        "peak_frequency_Hz": float(at["peak_frequency"]),
        "peak_mm_per_N": float(at["peak_amplitude"]) * 1e3 / force,
        "reason": str(at["reason"].item()),
    }


def peak_errors(response: xr.Dataset, reference: xr.Dataset, level: int) -> dict[str, float]:
    """Errors of a peak against the reference's [%], where both branches are complete."""
    peak, expected = peak_of_level(response, level), peak_of_level(reference, level)
    complete = peak["complete"] and expected["complete"]
    return {
        error: percent_error(peak[column], expected[column]) if complete else np.nan
        for error, column in PEAK_ERRORS.items()
    }


def with_converged_peaks(response: xr.Dataset) -> xr.Dataset:
    """The response with its converged peaks in place of its own, where it has such."""
    peaks = ("peak_frequency", "peak_amplitude")
    converged = {name: response.get(f"{name}_converged", response[name]) for name in peaks}
    return response.assign(converged)


def percent_error(value: float, reference: float) -> float:
    """Error against a reference [%]."""
    return 100 * (value / reference - 1)
