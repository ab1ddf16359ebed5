"""Wall and processor time of frequency responses, repeated within a time budget."""

import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.dynamics.balance.linear_modes import Jacobian
from boltjoint.dynamics.response.frequency_response import branch_solver, solve_branch
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import StepControl


def time_solver(
    joint: Joint,
    forces: Sequence[float],
    *,
    jacobians: Sequence[Jacobian],
    repeats: int = 3,
    time_budget_s: float = 0.5,
    **options: object,
) -> pd.DataFrame:
    """Time the frequency response at every force level, on one thread.

    A short run beforehand leaves compilation out of the measurement; levels alternate within a
    repeat, so that a slow moment of the machine does not fall on one level alone. The time of what
    all levels have in common, as a backbone, is divided equally among them.

    Parameters
    ----------
    joint, forces, **options
        As for ``solve_response``.
    jacobians
        Analytic, forward differences or both.
    repeats
        How often each force level is solved at most.
    time_budget_s
        A force level is not repeated once its solutions took so long in sum [s].

    Returns
    -------
    DataFrame
        Columns ``force_N, repeat, wall_s, cpu_s, solutions, iterations, jacobian, complete``.

    Raises
    ------
    ValueError
        If there is no force, a number is out of range, a Jacobian is not known, or as for
        ``solve_branch``.
    """
    forces = checks.levels("forces", forces)
    checks.whole("repeats", repeats, at_least=1)
    checks.number("time_budget_s", time_budget_s, at_least=0)
    checks.sequence("jacobians", jacobians)
    control = StepControl() if options.get("control") is None else options["control"]
    checks.instance("control", control, StepControl)
    for jacobian in jacobians:
        checks.choice("jacobians", jacobian, get_args(Jacobian))
    rows = []
    brief = replace(control, maximum_solutions=2)
    spent = dict.fromkeys(product(jacobians, forces), 0.0)
    with threadpool_limits(limits=1):
        for jacobian in jacobians:
            solve_branch(joint, forces[0], jacobian=jacobian, **options | {"control": brief})
        for repeat in range(repeats):
            for jacobian in jacobians:
                due = [force for force in forces if spent[jacobian, force] < time_budget_s]
                if not due:
                    continue
                begun = _clock()
                solve = branch_solver(joint, forces, jacobian=jacobian, **options)
                in_common = (_clock() - begun) / len(forces)
                for force in due:
                    begun = _clock()
                    branch = solve(force)
                    wall, cpu = _clock() - begun + in_common
                    spent[jacobian, force] += wall
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


def _clock() -> NDArray[np.float64]:
    """Wall and processor time [s]."""
    return np.array([time.perf_counter(), time.process_time()])
