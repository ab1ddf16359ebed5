"""Tables of computing times."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from boltjoint.names import REFERENCE


def tabulate_times(timings: Mapping[tuple[str, str, int], pd.DataFrame]) -> pd.DataFrame:
    """Median processor times of every response, and their reduction against the reference's.

    Parameters
    ----------
    timings
        ``timing.csv`` by joint, coordinates and resonance.

    Returns
    -------
    DataFrame
        A row for each response and force level, with columns for both ways to the Jacobian. A path
        that broke off has no reduction: it did less than the others.
    """
    parts = []
    for (joint, coordinates, resonance), timing in timings.items():
        medians = timing.pivot_table(index="force_N", columns="jacobian", aggfunc="median")
        analytic = medians.xs("analytic", axis=1, level="jacobian").reset_index()
        taken = "forward-difference" in medians.columns.get_level_values("jacobian")
        by_differences = medians["cpu_s"]["forward-difference"] if taken else None
        parts.append(
            pd.DataFrame(
                {
                    "joint": joint,
                    "coordinates": coordinates,
                    "resonance": resonance,
                    "force_N": analytic["force_N"],
                    "cpu_s": analytic["cpu_s"],
                    "cpu_forward_difference_s": by_differences.to_numpy() if taken else np.nan,
                    "solutions": analytic["solutions"].astype(int),
                    "iterations": analytic["iterations"].astype(int),
                    "complete": medians["complete"].min(axis=1).to_numpy() == 1,
                }
            )
        )
    table = pd.concat(parts, ignore_index=True)
    times = ["cpu_s", "cpu_forward_difference_s"]
    on = ["resonance", "force_N"]
    is_reference = (table["joint"] == REFERENCE[0]) & (table["coordinates"] == REFERENCE[1])
    reference = table.loc[is_reference & table["complete"], [*on, *times]]
    joined = table.merge(reference, how="left", on=on, suffixes=("", "_of_reference"))
    for name, column in zip(
        ("reduction_percent", "reduction_forward_difference_percent"), times, strict=True
    ):
        reduction = 100 * (1 - joined[column] / joined[f"{column}_of_reference"])
        table[name] = reduction.where(joined["complete"])
    return table
