"""How long does a frequency response take? Wall and processor time, repeated."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import pandas as pd
from threadpoolctl import threadpool_limits

from boltjoint.continuation import StepControl
from boltjoint.coordinates import Jacobian
from boltjoint.joint import Joint
from boltjoint.response import solve_branch


def time_solver(
    joint: Joint,
    forces: Sequence[float],
    *,
    repeats: Mapping[Jacobian, int],
    **options: object,
) -> pd.DataFrame:
    """Time the frequency response at every force level, on one thread.

    A short run beforehand leaves compilation out of the measurement; levels alternate within a
    repeat, so that a slow moment of the machine does not fall on one level alone.

    Parameters
    ----------
    joint, forces, **options
        As for ``response.solve_response``.
    repeats
        How often each force level is solved, by way to the Jacobian.

    Returns
    -------
    DataFrame
        Columns ``force_N, repeat, wall_s, cpu_s, solutions, iterations, jacobian, complete``.
    """
    rows = []
    brief = replace(options.get("control") or StepControl(), most_solutions=2)
    with threadpool_limits(limits=1):
        for jacobian in repeats:
            solve_branch(joint, forces[0], jacobian=jacobian, **options | {"control": brief})
        for repeat in range(max(repeats.values())):
            for jacobian in (name for name, times in repeats.items() if repeat < times):
                for force in forces:
                    wall, cpu = time.perf_counter(), time.process_time()
                    branch = solve_branch(joint, force, jacobian=jacobian, **options)
                    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
                    rows.append(
                        {
                            "force_N": force,
                            "repeat": repeat,
                            "wall_s": wall,
                            "cpu_s": cpu,
                            "solutions": branch.frequency.size,
                            "iterations": int(branch.iterations.sum()),
                            "jacobian": jacobian,
                            "complete": int(branch.complete),
                        }
                    )
    return pd.DataFrame(rows)
