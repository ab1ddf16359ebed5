"""Tables of the errors of joints and coordinates against a reference, and the measures of these."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.harmonics import harmonics_of_level
from boltjoint.names import REFERENCE
from boltjoint.structure.model_limits import LIMITS

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
    """Harmonics, solutions, completeness and peak of a force level."""
    levels = checks.variable("response", response, "force_level", ("force",))
    level = checks.whole("level", level, at_least=0, below=len(levels))
    at = response.isel(force=level)
    force = float(at["force_level"])
    return {
        "response_harmonics": harmonics_of_level(response, level),
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


def tabulate_accuracy(
    responses: Mapping[tuple[str, str, int], xr.Dataset],
    checks: Mapping[tuple[str, str, int], pd.DataFrame],
) -> pd.DataFrame:
    """Errors of every response of a case against the node-to-node joint in linear modes.

    Parameters
    ----------
    responses
        ``response.nc`` by joint, coordinates and resonance.
    checks
        ``check.csv`` of those whose residual in time was found.

    Returns
    -------
    DataFrame
        A row for each response and force level. Errors are empty where there is no reference, or
        one of the two branches is not complete; ``reason`` then says why. ``response_harmonics``
        are those of the branch, ``harmonics`` those of its converged peak.
        ``energy_error`` and ``residual``, in all linear modes over the force, are the largest of
        all solutions; estimated errors are those of the response file, without any reference;
        with converged peaks, these and the error bars of the peak are beside them;
        ``largest_multiplier`` is the largest where the branch folds, beyond 1 where a motion is
        unstable, and ``stability_harmonics`` the fewest of these motions, 0 without;
        ``isolated_branch`` is empty where it is not known;
        ``residual_in_time`` is the largest, and lies at ``worst_in_time_Hz``.
    """
    rows = []
    for (joint, coordinates, resonance), response in responses.items():
        reference = responses.get((*REFERENCE, resonance))
        for level, force in enumerate(response["force_level"].to_numpy()):
            row = peak_of_level(response, level)
            row |= dict.fromkeys((*PEAK_ERRORS, "curve_error_dB"), np.nan)
            if (
                reference is not None
                and row["complete"]
                and peak_of_level(reference, level)["complete"]
            ):
                row |= peak_errors(response, reference, level)
                curves = _curve(response, level), _curve(reference, level)
                row["curve_error_dB"] = curve_error(*curves)
            mine = (response["excitation_force"] == force) & (response["converged"] == 1)
            for name in ("energy_error", "residual"):
                row[name] = float(abs(response[name].where(mine)).to_series().max())
            row |= _error_estimates(response.isel(force=level))
            row |= _error_bars(response.isel(force=level))
            for limit in LIMITS:
                if f"peak_{limit.name}" in response:
                    share = float(response[f"peak_{limit.name}"][level])
                    row[f"{limit.name}_percent"] = 100 * share
            row["largest_multiplier"] = float(response["largest_multiplier"].where(mine).max())
            harmonics = response["stability_harmonics"].where(mine & (response["stable"] >= 0))
            row["stability_harmonics"] = int(harmonics.min().fillna(0))
            where = {"joint": joint, "coordinates": coordinates, "resonance": resonance}
            rows.append({**where, "force_N": force, **row})
    table = pd.DataFrame(rows)
    residuals = [
        check[["force_N", "residual_in_time", "frequency_Hz"]]
        .rename(columns={"frequency_Hz": "worst_in_time_Hz"})
        .assign(joint=joint, coordinates=coordinates, resonance=resonance)
        for (joint, coordinates, resonance), check in checks.items()
    ]
    if residuals:
        on = ["joint", "coordinates", "resonance", "force_N"]
        table = table.merge(pd.concat(residuals), how="left", on=on)
    return table[[name for name in table if name != "reason"] + ["reason"]]


def tabulate_models(
    responses: Mapping[tuple[str, str, str, int], xr.Dataset],
    timings: Mapping[tuple[str, str, str, int], pd.DataFrame],
    converged: tuple[str, str, str, int],
) -> pd.DataFrame:
    """Errors of all responses of a case, in any basis, against the reference model, and their cost.

    The reference is the converged response with as many harmonics as converge, where it has such
    peaks; else with its own.

    Parameters
    ----------
    responses, timings
        ``response.nc`` and ``timing.csv`` by modal basis, joint, coordinates and resonance.
    converged
        Which of them the others, and itself, are compared with.

    Returns
    -------
    DataFrame
        A row for each response and force level: errors of its peak, empty where the branch is
        not complete or the reference has no peak, and the median processor time.
    """
    rows = []
    reference = with_converged_peaks(responses[converged])
    for model, response in responses.items():
        timing = timings[model]
        cost = timing.set_index("force_N")["cpu_s"]
        for level, force in enumerate(response["force_level"].to_numpy()):
            rows.append(
                {
                    **dict(zip(("modes", "joint", "coordinates", "resonance"), model, strict=True)),
                    "force_N": force,
                    "complete": peak_of_level(response, level)["complete"],
                    **peak_errors(response, reference, level),
                    "cpu_s": cost.get(force, np.nan),
                }
            )
    return pd.DataFrame(rows)


def tabulate_sensors(response: xr.Dataset) -> pd.DataFrame:
    """Largest amplitude of each sensor at each excitation level.

    Parameters
    ----------
    response
        ``response.nc``.

    Returns
    -------
    DataFrame
        Columns ``sensor, force_N, peak_frequency_Hz, peak_mm_per_N``, empty where the branch has no
        peak, ``harmonics`` and ``error_of_output_percent``, the error bar of the response of the
        output point with these harmonics; ``error`` in words where that is not known.

    Raises
    ------
    ValueError
        If there is no sensor or level, or no peak of each.
    """
    levels = checks.variable("response", response, "force_level", ("force",), above=0)
    frequency, amplitude = (
        checks.variable(
            "response", response, f"sensor_peak_{quantity}", ("sensor", "force"), finite=False
        )
        for quantity in ("frequency", "amplitude")
    )
    bars = response.get("peak_amplitude_error", xr.full_like(response["force_level"], np.nan))
    # without the error of the basis a bar would say too little
    is_tested = bool(np.isfinite(bars + response.get("basis_amplitude_error", np.nan)).any())
    rows = [
        {
            "sensor": str(name),
            "force_N": float(force),
            "peak_frequency_Hz": frequency[i, j],
            "peak_mm_per_N": 1e3 * amplitude[i, j] / force,
            "harmonics": harmonics_of_level(response, j),
            **(
                {"error_of_output_percent": 100 * float(bars[j])}
                if is_tested
                else {"error": "not tested"}
            ),
        }
        for i, name in enumerate(response["sensor"].to_numpy())
        for j, force in enumerate(levels)
    ]
    return pd.DataFrame(rows)


def _error_estimates(at: xr.Dataset) -> dict[str, Any]:
    """Estimated errors and folds of a response at a force level."""
    return {
        "estimated_peak_error_percent": 100 * float(at["peak_error_estimate"]),
        "estimated_largest_error_percent": 100 * float(at["largest_error_estimate"]),
        "wrong": bool(at["wrong"]),
        "fell_back": bool(at["fell_back"]),
        "turning_points": int(at["turning_points"]),
        "folded_from_Hz": float(at["folded_from"]),
        "folded_to_Hz": float(at["folded_to"]),
        "folded_from_converged_Hz": float(at["folded_from_converged"]),
        "folded_to_converged_Hz": float(at["folded_to_converged"]),
        "isolated_branch": {0: False, 1: True}.get(int(at["isolated_branch"])),
    }


def _error_bars(at: xr.Dataset) -> dict[str, float]:
    """Converged peak of a force level, and error bars of its own peak; nothing without."""
    if "peak_harmonics" not in at:
        return {}
    return {
        "converged_peak_frequency_Hz": float(at["peak_frequency_converged"]),
        "converged_frequency_error_bar_percent": 100 * float(at["peak_frequency_converged_error"]),
        "converged_peak_mm_per_N": 1e3 * float(at["peak_amplitude_converged"] / at["force_level"]),
        "converged_amplitude_error_bar_percent": 100 * float(at["peak_amplitude_converged_error"]),
        "basis_amplitude_error_percent": 100 * float(at.get("basis_amplitude_error", np.nan)),
        "harmonics": float(at["peak_harmonics"]),
        "frequency_error_bar_percent": 100 * float(at["peak_frequency_error"]),
        "amplitude_error_bar_percent": 100 * float(at["peak_amplitude_error"]),
    }


def _curve(response: xr.Dataset, level: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    mine = response["excitation_force"].to_numpy() == float(response["force_level"][level])
    return response["frequency"].to_numpy()[mine], response["response_amplitude"].to_numpy()[mine]
