"""Table of the largest amplitudes of sensors."""

import pandas as pd
import xarray as xr


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
    """
    rows = []
    for name in response["sensor"].to_numpy():
        of_sensor = response.sel(sensor=name)
        for level, force in enumerate(response["force_level"].to_numpy()):
            frequency, amplitude = (
                float(of_sensor[f"sensor_peak_{each}"][level])
                for each in ("frequency", "amplitude")
            )
            rows.append((str(name), float(force), frequency, 1e3 * amplitude / force))
    columns = ["sensor", "force_N", "peak_frequency_Hz", "peak_mm_per_N"]
    return pd.DataFrame(rows, columns=columns)
