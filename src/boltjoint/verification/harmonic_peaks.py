"""Table of the peaks of the first harmonic by number of harmonics."""

import logging
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint import checks
from boltjoint.damping import damping_of_attributes
from boltjoint.dynamics.harmonic_balance import parse_component
from boltjoint.dynamics.periodic_motion import motion_at_peak
from boltjoint.dynamics.phase_resonance import find_peak
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint

logger = logging.getLogger(__name__)


def tabulate_peaks(
    joint: Joint,
    response: xr.Dataset,
    *,
    forces: Sequence[float],
    harmonics: Sequence[int] = (3, 5, 7, 9),
) -> pd.DataFrame:
    """Peaks by the number of harmonics, each at its own frequency.

    Parameters
    ----------
    joint, response
        A joint and its ``response.nc``, whose peaks the table begins with.
    forces
        Force levels of the response.
    harmonics
        Further numbers of harmonics, each started from the one before.

    Returns
    -------
    DataFrame
        A row for each force and number of harmonics with columns ``force_N, harmonics,
        peak_frequency_Hz, peak_mm_per_N`` (NaN without a peak), and ``peak_frequency_error_percent,
        peak_amplitude_error_percent`` against the most harmonics with a peak, NaN without others.

    Raises
    ------
    ValueError
        If a force is not among the levels of the response.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("response", response, xr.Dataset)
    forces = checks.numbers("forces", forces)
    if not np.isin(forces, response["force_level"]).all():
        raise ValueError(f"forces are {forces}: they must be among the levels of the response")
    damping = damping_of_attributes(response.attrs)
    of_response = max(parse_component(str(name))[1] for name in response["component"].to_numpy())
    harmonics = [number for number in harmonics if number > of_response]
    if isinstance(joint.law, AlternatingFrequencyTime):
        joint = replace(joint, law=joint.law.elements)
    joint, rows = joint.distinct, []
    for force in forces:
        peaks = {}
        at_peak = response.sel(force=response["force_level"].to_numpy() == force)
        if np.isfinite(at_peak["peak_frequency"]).all():
            peak = motion_at_peak(response, force)
            peaks[of_response] = peak
            for highest in harmonics:
                frequency, motion = peak
                found = find_peak(joint, frequency, force, damping, motion, harmonics=highest)
                logger.info("%g N, %d harmonics: %s", force, highest, found and found[0])
                if found is not None:
                    peaks[highest] = peak = found
        for highest in (of_response, *harmonics):
            frequency, motion = peaks.get(highest, (np.nan, None))
            amplitude = np.nan if motion is None else abs(motion.amplitude(joint.response_mode))
            rows.append((float(force), highest, frequency, 1e3 * amplitude / force))
    columns = ["force_N", "harmonics", "peak_frequency_Hz", "peak_mm_per_N"]
    table = pd.DataFrame(rows, columns=columns)
    by_force = table.dropna().groupby("force_N")
    reference = by_force.last()[by_force.size() > 1]
    for what, column in (("frequency", columns[2]), ("amplitude", columns[3])):
        ratio = table[column] / table["force_N"].map(reference[column])
        table[f"peak_{what}_error_percent"] = 100 * (ratio - 1)
    return table
