"""How fast do sampled forces approach the exact ones?"""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint.friction.sampled import SampledInTime
from boltjoint.joint import Joint


def tabulate_sampling(
    solved: Mapping[str, tuple[Joint, xr.Dataset]],
    samples: Sequence[int] = (64, 128, 256, 512, 1024),
) -> pd.DataFrame:
    """Error of sampled forces against the exact ones, at the largest response to each force.

    Parameters
    ----------
    solved
        Joint and ``response.nc`` of each case by its name, solved with exact forces.
    samples
        Samples a period.

    Returns
    -------
    DataFrame
        Columns ``case, law, samples, force_N, error_relative``: the error of the forces on all
        points in the Euclidean norm, relative to the exact ones.
    """
    rows = []
    for case, (joint, response) in solved.items():
        for force, motion in _largest_motions(joint, response).items():
            exact = joint.law.force(motion)
            for count in samples:
                sampled = SampledInTime(joint.law, samples=count).force(motion)
                rows.append(
                    {
                        "case": case,
                        "law": joint.law.name,
                        "samples": count,
                        "force_N": force,
                        "error_relative": np.linalg.norm(sampled - exact) / np.linalg.norm(exact),
                    }
                )
    return pd.DataFrame(rows)


def _largest_motions(joint: Joint, response: xr.Dataset) -> dict[float, np.ndarray]:
    """Motion of the contact points where the response to each force is largest, by force."""
    components = list(joint.law.components)
    amplitude = response["modal_coordinate"].sel(component=components)
    found = {}
    for force in response["force_level"].to_numpy():
        mine = np.flatnonzero(response["excitation_force"].to_numpy() == force)
        at = mine[np.argmax(response["response_amplitude"].to_numpy()[mine])]
        q = amplitude.isel(solution=at).transpose("mode", "component").to_numpy()
        found[float(force)] = np.hstack([row @ q for row in joint.rows])
    return found
