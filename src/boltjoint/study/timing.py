"""Wall and processor time of frequency responses, repeated within a time budget."""

import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.response.methods import Method, Problem
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import StepControl


def time_solver(
    joint: Joint,
    forces: Sequence[float],
    methods: Sequence[Method],
    *,
    damping: Damping | float,
    resonance: Resonance | int = 1,
    control: StepControl | None = None,
    repeats: int = 3,
    time_budget_s: float = 0.5,
) -> pd.DataFrame:
    """Time the frequency response at every force level, on one thread.

    A short run beforehand leaves compilation out of the measurement; levels alternate within a
    repeat, so that a slow moment of the machine does not fall on one level alone. The time of what
    all levels have in common, as a backbone, is divided equally among them.

    Parameters
    ----------
    joint, forces, damping, resonance, control
        As for ``solve_response``.
    methods
        Methods that are timed, told apart by their Jacobian.
    repeats
        Largest number of times that a force level is solved.
    time_budget_s
        A force level is not repeated once its solutions took so long in sum [s].

    Returns
    -------
    DataFrame
        Columns ``force_N, repeat, wall_s, cpu_s, solutions, iterations, jacobian, complete``.

    Raises
    ------
    ValueError
        If there is no force, a number is out of range, or as for ``solve_branch``.
    """
    forces = checks.levels("forces", forces)
    checks.whole("repeats", repeats, at_least=1)
    checks.number("time_budget_s", time_budget_s, at_least=0)
    checks.sequence("methods", methods, Method)
    problem = Problem.of(joint, damping, resonance, control)
    joint.check_excitation(problem.resonance)
    brief = problem._replace(control=replace(problem.control, maximum_solutions=2))
    rows = []
    spent = dict.fromkeys(product(range(len(methods)), forces), 0.0)
    with threadpool_limits(limits=1):
        for method in methods:
            method.solve(brief, forces[0])
        for repeat in range(repeats):
            for number, method in enumerate(methods):
                due = [force for force in forces if spent[number, force] < time_budget_s]
                if not due:
                    continue
                begun = _clock()
                prepared = method.prepared(problem, forces)
                in_common = (_clock() - begun) / len(forces)
                for force in due:
                    begun = _clock()
                    branch = prepared.solve(problem, force)
                    wall, cpu = _clock() - begun + in_common
                    spent[number, force] += wall
                    rows.append(
                        {
                            "force_N": force,
                            "repeat": repeat,
                            "wall_s": wall,
                            "cpu_s": cpu,
                            "solutions": branch.frequency.size,
                            "iterations": int(branch.iterations.sum()),
                            "jacobian": method.jacobian,
                            "complete": int(branch.complete),
                        }
                    )
    return pd.DataFrame(rows)


def _clock() -> NDArray[np.float64]:
    """Wall and processor time [s]."""
    return np.array([time.perf_counter(), time.process_time()])
