"""One harmonic and many against time integration, as a table."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint import checks
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint
from boltjoint.verification.multi_harmonic import largest_response, solve_periodic
from boltjoint.verification.time_integration import steady_state

#: of the table of harmonics and march
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
    steps: int = 2000,
) -> pd.DataFrame:
    """First harmonic of the response by the number of harmonics balanced, and in time.

    At the frequency at which the response to each force is largest. The march begins with the
    motion of the most harmonics, and once more at rest: the sliders of contacts that never slip
    through, and where there are several motions the motion itself, may depend on how it began.

    Parameters
    ----------
    joint, response
        ``joint.nc`` and the ``response.nc`` of it, of any number of harmonics.
    forces
        Those of its force levels to take; by default all.
    harmonics
        Highest harmonics of the balances, each of which starts from the one before. The last should
        reach beyond the modes of the joint while all contact sticks.
    samples
        Samples a period of the balances.
    steps
        Steps a period of the coarser march.

    Returns
    -------
    DataFrame
        A row for each force and number of harmonics with columns ``force_N, frequency_Hz,
        harmonics, amplitude_m`` (NaN where the balance was not solved) and ``in_time_m``, the
        amplitude of the march; ``difference_percent`` of the balance from the march;
        ``from_rest_percent``, that of the march from rest; ``step_error_percent``,
        ``steps_per_period``, ``periods`` and ``change_per_period`` of the march, and whether both
        marches are ``settled``.

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
    loss_factor = response.attrs["loss_factor"]
    rows = []
    for force in forces:
        if (largest := largest_response(response, force)) is None:
            continue
        frequency, motion = largest
        excitation = float(frequency), float(force), loss_factor
        balanced = {}
        for highest in harmonics:
            found = solve_periodic(
                joint, *excitation, harmonics=highest, samples=samples, start=motion
            )
            amplitude = abs(found.amplitude(joint.response_mode))
            balanced[highest] = amplitude if found.converged else np.nan
            motion = found if found.converged else motion
        march = steady_state(joint, *excitation, start=motion.in_time(steps), steps=steps)
        from_rest = steady_state(joint, *excitation, steps=steps)
        in_time = abs(march.amplitude)
        for highest, amplitude in balanced.items():
            rows.append(
                {
                    "force_N": float(force),
                    "frequency_Hz": frequency,
                    "harmonics": highest,
                    "amplitude_m": amplitude,
                    "in_time_m": in_time,
                    "difference_percent": 100 * (amplitude / in_time - 1),
                    "from_rest_percent": 100 * (abs(from_rest.amplitude) / in_time - 1),
                    "step_error_percent": 100 * march.step_error,
                    "steps_per_period": march.steps,
                    "periods": march.periods,
                    "change_per_period": march.change,
                    "settled": march.settled and from_rest.settled,
                }
            )
    return pd.DataFrame(rows, columns=_COLUMNS)
