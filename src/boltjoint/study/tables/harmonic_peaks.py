"""Tables of the peaks of a response: by number of harmonics, and in a larger basis."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint import checks
from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.joint.model import Joint
from boltjoint.solvers.step_control import StepControl
from boltjoint.verification.multi_harmonic import checked_levels

#: what is read of a response, by its dimensions
_READ = {
    ("force",): (
        *("force_level", "peak_harmonics"),
        *("peak_frequency_truncation_error", "peak_amplitude_truncation_error"),
        *("superharmonic_order", "superharmonic_frequency", "superharmonic_share"),
    ),
    ("force", "harmonics"): ("harmonic_peak_frequency", "harmonic_peak_amplitude"),
}


def tabulate_harmonic_peaks(response: xr.Dataset) -> pd.DataFrame:
    """Peaks by number of harmonics, as many as were tried.

    Parameters
    ----------
    response
        ``response.nc`` with its converged peaks (``dynamics.response.converged_peaks``).

    Returns
    -------
    DataFrame
        A row for each force and number of harmonics with which the peak was found, with columns
        ``force_N, harmonics, peak_frequency_Hz, peak_mm_per_N``; ``peak_frequency_error_percent``
        and ``peak_amplitude_error_percent`` against the most harmonics with a peak, empty where
        they are not enough; and of that last peak, ``frequency_truncation_error_percent`` and
        ``amplitude_truncation_error_percent``, ``basis_amplitude_error_percent``, which is empty
        where it is not estimated, and ``superharmonic``: the harmonic in resonance and that
        resonance, or nothing.

    Raises
    ------
    ValueError
        If the response has no converged peaks.
    """
    for dims, names in _READ.items():
        for name in names:
            checks.variable("response", response, name, dims, finite=False)
    rows = []
    for place in range(response.sizes["force"]):
        at = response.isel(force=place)
        force, most = float(at["force_level"]), float(at["peak_harmonics"])
        peaks = at[["harmonic_peak_frequency", "harmonic_peak_amplitude"]].dropna("harmonics")
        last = np.array([np.nan, np.nan])
        if np.isfinite(most):
            if most not in peaks["harmonics"]:
                raise ValueError(f"peak_harmonics is {most:g}, but there is no peak with as many")
            last = peaks.sel(harmonics=most).to_array().to_numpy()
        for number in peaks["harmonics"].to_numpy():
            peak = peaks.sel(harmonics=number).to_array().to_numpy()
            is_last = number == most
            errors = at[[f"peak_{what}_truncation_error" for what in ("frequency", "amplitude")]]
            rows.append(
                (
                    force,
                    int(number),
                    peak[0],
                    1e3 * peak[1] / force,
                    *(100 * (peak / last - 1)),
                    *(100 * errors.to_array().to_numpy() if is_last else (np.nan, np.nan)),
                    100 * float(response.get("basis_amplitude_error", np.nan)),
                    _superharmonic(at) if is_last else "",
                )
            )
    columns = ["force_N", "harmonics", "peak_frequency_Hz", "peak_mm_per_N"]
    columns += ["peak_frequency_error_percent", "peak_amplitude_error_percent"]
    columns += ["frequency_truncation_error_percent", "amplitude_truncation_error_percent"]
    columns += ["basis_amplitude_error_percent"]
    return pd.DataFrame(rows, columns=[*columns, "superharmonic"])


def _superharmonic(at: xr.Dataset) -> str:
    """The harmonic in resonance at a force level in words; nothing without one."""
    order = int(at["superharmonic_order"])
    if not order:
        return ""
    frequency, share = (float(at[f"superharmonic_{what}"]) for what in ("frequency", "share"))
    return f"{order} at {frequency:.1f} Hz, {100 * share:.2g} %"


#: change of a peak that ends the search for more harmonics: none, before the last number of them
_NO_CHANGE = 1e-12


def tabulate_larger_basis(
    response: xr.Dataset,
    joint: Joint,
    forces: Sequence[float],
    control: StepControl | None = None,
) -> pd.DataFrame:
    """Peaks of a response against those in a larger basis, by number of harmonics.

    Parameters
    ----------
    response
        ``response.nc`` of the first resonance with its converged peaks.
    joint
        The same joint in the larger basis.
    forces
        Force levels of the response.
    control
        As for ``solve_response``.

    Returns
    -------
    DataFrame
        A row for each force and number of harmonics with which both have a peak, with columns
        ``force_N, harmonics``, of the larger basis ``peak_frequency_Hz, peak_mm_per_N``, and the
        errors of the response, ``peak_frequency_error_percent, peak_amplitude_error_percent``.

    Raises
    ------
    ValueError
        If a force is not among the levels of the response, it has no converged peaks, or as for
        ``solve_response``.
    """
    joint, forces, damping = checked_levels(joint, response, forces)
    if "harmonics" not in response.dims:
        raise ValueError("response has no converged peaks")
    numbers = response["harmonics"].to_numpy().tolist()
    tried = HarmonicConvergence(tuple(numbers[1:]), _NO_CHANGE, _NO_CHANGE)
    in_larger = solve_response(joint, forces, damping=damping, control=control)
    in_larger = in_larger.merge(converge_peaks(joint, in_larger, tried, left_out=None))
    keys, peaks = ["force_N", "harmonics"], ["peak_frequency_Hz", "peak_mm_per_N"]
    own, larger = (
        tabulate_harmonic_peaks(solved).set_index(keys)[peaks] for solved in (response, in_larger)
    )
    errors = (100 * (own / larger - 1)).dropna()
    errors.columns = ["peak_frequency_error_percent", "peak_amplitude_error_percent"]
    return larger.join(errors, how="inner").reset_index()
