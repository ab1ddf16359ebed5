"""Table of multi-harmonic balances against time integration."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint import checks
from boltjoint.damping import damping_of_attributes
from boltjoint.dynamics.periodic_motion import motion_at_peak
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint
from boltjoint.verification.multi_harmonic import solve_periodic
from boltjoint.verification.time_integration import steady_state

#: of the table of harmonics and time integration
_COLUMNS = (
    "force_N",
    "frequency_Hz",
    "harmonics",
    "amplitude_m",
    "in_time_m",
    "difference_percent",
    "from_rest_percent",
    "step_error_percent",
    "steps_per_period",
    "periods",
    "change_per_period",
    "settled",
)


def tabulate_time_integration(
    joint: Joint,
    response: xr.Dataset,
    *,
    forces: Sequence[float] | None = None,
    harmonics: Sequence[int] = (1, 3, 5, 9, 25, 51, 101, 201),
    samples: int = 1024,
    steps: int = 1000,
) -> pd.DataFrame:
    """First harmonic of the response by number of harmonics and by time integration.

    At the peak frequency of each force. The integration starts from the motion of the most
    harmonics, and once more at rest: the residual tractions of contacts without full slip, and the
    motion itself where there are several, depend on the start.

    Parameters
    ----------
    joint, response
        ``joint.nc`` and the ``response.nc`` of it, of any number of harmonics.
    forces
        Force levels of the response; by default all.
    harmonics
        Numbers of harmonics, each started from the one before. The last should reach beyond the
        stuck modes of the joint.
    samples
        Time samples a period of the multi-harmonic balances.
    steps
        Steps a period of the coarser time integration.

    Returns
    -------
    DataFrame
        A row for each force and number of harmonics with columns ``force_N, frequency_Hz,
        harmonics, amplitude_m`` (NaN where the balance did not converge); ``in_time_m``, the
        amplitude by time integration; the differences from it, ``difference_percent`` of the
        balance and ``from_rest_percent`` of the integration from rest; ``step_error_percent``,
        ``steps_per_period``, ``periods`` and ``change_per_period`` of the integration;
        ``settled``, whether both integrations converged.

    Raises
    ------
    ValueError
        If a force is not among the levels of the response, or as for ``steady_state``.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("response", response, xr.Dataset)
    levels = response["force_level"].to_numpy()
    forces = levels if forces is None else checks.numbers("forces", forces)
    if not np.isin(forces, levels).all():
        raise ValueError(f"forces are {forces}: they must be among the levels of the response")
    harmonics = [checks.whole("harmonics", each, at_least=1) for each in harmonics]
    samples = checks.whole("samples", samples, at_least=2 * max(harmonics) + 1)
    steps = checks.whole("steps", steps, at_least=3)
    if isinstance(joint.law, AlternatingFrequencyTime):
        joint = replace(joint, law=joint.law.elements)
    joint = joint.distinct
    damping = damping_of_attributes(response.attrs)
    rows = []
    for force in forces:
        if (peak := motion_at_peak(response, force)) is None:
            continue
        frequency, motion = peak
        excitation = float(frequency), float(force), damping
        amplitudes = {}
        for highest in harmonics:
            solution = solve_periodic(
                joint, *excitation, harmonics=highest, samples=samples, start=motion
            )
            amplitude = abs(solution.amplitude(joint.response_mode))
            amplitudes[highest] = amplitude if solution.converged else np.nan
            motion = solution if solution.converged else motion
        integrated = steady_state(joint, *excitation, start=motion.in_time(steps), steps=steps)
        from_rest = steady_state(joint, *excitation, steps=steps)
        in_time = abs(integrated.amplitude)
        from_rest_percent = 100 * (abs(from_rest.amplitude) / in_time - 1)
        accuracy = 100 * integrated.step_error, integrated.steps, integrated.periods
        settled = integrated.converged and from_rest.converged
        for highest, amplitude in amplitudes.items():
            place = float(force), frequency, highest
            difference_percent = 100 * (amplitude / in_time - 1)
            compared = amplitude, in_time, difference_percent, from_rest_percent
            rows.append((*place, *compared, *accuracy, integrated.change, settled))
    return pd.DataFrame(rows, columns=_COLUMNS)
