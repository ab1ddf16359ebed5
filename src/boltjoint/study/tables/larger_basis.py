"""Table of the peaks of a response with many harmonics, against those in a larger basis."""

from collections.abc import Sequence

import pandas as pd
import xarray as xr

from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.peak_sequence import HarmonicConvergence
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import StepControl
from boltjoint.study.tables.harmonics import tabulate_harmonic_peaks
from boltjoint.verification.harmonics_table import checked_levels

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
    in_larger = in_larger.merge(converge_peaks(joint, in_larger, tried))
    keys, peaks = ["force_N", "harmonics"], ["peak_frequency_Hz", "peak_mm_per_N"]
    own, larger = (
        tabulate_harmonic_peaks(solved).set_index(keys)[peaks] for solved in (response, in_larger)
    )
    errors = (100 * (own / larger - 1)).dropna()
    errors.columns = ["peak_frequency_error_percent", "peak_amplitude_error_percent"]
    return larger.join(errors, how="inner").reset_index()
