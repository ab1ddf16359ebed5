"""Timing of frequency responses, and tables of the times."""

import time
from collections.abc import Mapping, Sequence
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
from boltjoint.names import REFERENCE
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
                    "cpu_forward_difference_s": np.nan
                    if by_differences is None
                    else by_differences.to_numpy(),
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
