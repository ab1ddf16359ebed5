"""How long does a frequency response take? Wall and processor time, repeated."""

import time
from collections.abc import Sequence

import pandas as pd
from threadpoolctl import threadpool_limits

from boltjoint.coordinates import Jacobian
from boltjoint.joint import Joint
from boltjoint.response import solve_branch


def time_solver(
    joint: Joint,
    forces: Sequence[float],
    *,
    repeats: int,
    jacobians: Sequence[Jacobian] = ("analytic", "forward-difference"),
    **options: object,
) -> pd.DataFrame:
    """Time the frequency response at every force level, on one thread.

    A run beforehand leaves compilation out of the measurement; levels alternate within a repeat, so
    that a slow moment of the machine does not fall on one level alone.

    Parameters
    ----------
    joint, forces, **options
        As for ``response.solve_response``.
    repeats
        How often each force level is solved.
    jacobians
        Ways to the Jacobian that are timed.

    Returns
    -------
    DataFrame
        Columns ``force_N, repeat, wall_s, cpu_s, solutions, iterations, jacobian, complete``.
    """
    rows = []
    with threadpool_limits(limits=1):
        for jacobian in jacobians:
            solve_branch(joint, forces[0], jacobian=jacobian, **options)
        for repeat in range(repeats):
            for jacobian in jacobians:
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
