"""Table of the largest amplitudes of sensors."""

import pandas as pd
import xarray as xr

from boltjoint import checks


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
        peak.

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
    rows = []
    for i, name in enumerate(response["sensor"].to_numpy()):
        for j, force in enumerate(levels):
            rows.append((str(name), float(force), frequency[i, j], 1e3 * amplitude[i, j] / force))
    columns = ["sensor", "force_N", "peak_frequency_Hz", "peak_mm_per_N"]
    return pd.DataFrame(rows, columns=columns)
