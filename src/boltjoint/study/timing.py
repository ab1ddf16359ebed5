"""Times of frequency responses, and tables of them."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self, get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.balance.balance_equations import Jacobian
from boltjoint.dynamics.response.branch import Branch
from boltjoint.dynamics.response.methods import Method, Problem
from boltjoint.names import REFERENCE


@dataclass(frozen=True)
class Timed(Method):
    """A method that takes the time of each response which it solves.

    Nothing is solved for the times alone but two solutions beforehand, which leave compilation out
    of them. The time of what all levels have in common, as a backbone, is divided equally among
    them.

    Parameters
    ----------
    method
        The method that is timed.
    rows
        What was measured, a row for each response.
    in_common
        Wall and processor time of what all levels have in common [s]: of all before ``prepared``,
        for each of them after it.
    jacobian, limits, has_fallback, repeats
        Those of the method, which ``Timed.of`` copies.

    Raises
    ------
    ValueError
        If the method is none.
    """

    method: Method
    rows: list[dict[str, Any]] = field(default_factory=list)
    in_common: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, method: Method, before: tuple[float, float] = (0.0, 0.0)) -> Self:
        """The method, timed; ``before`` it what all levels have in common took so long [s]."""
        checks.instance("method", method, Method)
        names = "jacobian", "limits", "has_fallback", "repeats"
        return cls(method, in_common=before, **{name: getattr(method, name) for name in names})

    @property
    def name(self) -> str:
        """That of the method."""
        return self.method.name

    @property
    def knows_harmonics(self) -> bool:
        """As of the method."""
        return self.method.knows_harmonics

    @property
    def has_error(self) -> bool:
        """As of the method."""
        return self.method.has_error

    def prepared(self, problem: Problem, forces: Sequence[float]) -> Self:
        """The method with what all levels have in common, once its code is compiled."""
        brief = problem._replace(control=replace(problem.control, maximum_solutions=2))
        self.method.solve(brief, forces[0])
        begun = clock()
        prepared = self.method.prepared(problem, forces)
        wall, cpu = (clock() - begun + self.in_common) / len(forces)
        return replace(self, method=prepared, in_common=(wall, cpu))

    def solve(
        self, problem: Problem, force: float, start: NDArray[np.float64] | None = None
    ) -> Branch:
        """The response to a force, as ``solve_branch``."""
        begun = clock()
        branch = self.method.solve(problem, force, start)
        wall, cpu = clock() - begun + self.in_common
        self.rows.append(
            {
                "force_N": force,
                "repeat": 0,
                "wall_s": wall,
                "cpu_s": cpu,
                "solutions": branch.frequency.size,
                "iterations": int(branch.iterations.sum()),
                "jacobian": self.jacobian,
                "complete": int(branch.complete),
            }
        )
        return branch

    @property
    def times(self) -> pd.DataFrame:
        """``timing.csv``: the rows of all responses solved so far.

        Columns ``force_N, repeat, wall_s, cpu_s, solutions, iterations, jacobian, complete``.
        """
        return pd.DataFrame(self.rows)


def clock() -> NDArray[np.float64]:
    """Wall and processor time [s]."""
    return np.array([time.perf_counter(), time.process_time()])


def tabulate_times(timings: Mapping[tuple[str, str, int], pd.DataFrame]) -> pd.DataFrame:
    """Processor times of every response, and their reduction against the reference's.

    Parameters
    ----------
    timings
        ``timing.csv`` by joint, coordinates and resonance, with the rows of
        ``forward_differences.csv`` where that is.

    Returns
    -------
    DataFrame
        A row for each response and force level, with columns for both ways to the Jacobian, not a
        number where one was not taken: nor is it complete. A path that broke off has no reduction,
        as it did less than the others, and where that of the reference did, none has.
    """
    parts = []
    for (joint, coordinates, resonance), timing in timings.items():
        by_force = timing.groupby("force_N")
        cpu, complete = (
            timing.pivot_table(index="force_N", columns="jacobian", values=name).reindex(
                columns=get_args(Jacobian)
            )
            for name in ("cpu_s", "complete")
        )
        whole = cpu.where(complete == 1)
        parts.append(
            pd.DataFrame(
                {
                    "joint": joint,
                    "coordinates": coordinates,
                    "resonance": resonance,
                    "cpu_s": cpu["analytic"],
                    "cpu_forward_difference_s": cpu["forward-difference"],
                    **by_force[["solutions", "iterations"]].first(),
                    "complete": complete["analytic"] == 1,
                    "complete_forward_difference": complete["forward-difference"] == 1,
                    "reduction_percent": whole["analytic"],
                    "reduction_forward_difference_percent": whole["forward-difference"],
                }
            ).reset_index()
        )
    table = pd.concat(parts, ignore_index=True)
    # so far the times of whole paths
    reductions = ["reduction_percent", "reduction_forward_difference_percent"]
    is_reference = (table["joint"] == REFERENCE[0]) & (table["coordinates"] == REFERENCE[1])
    on = ["resonance", "force_N"]
    of_reference = table[on].merge(table.loc[is_reference, [*on, *reductions]], how="left", on=on)
    table[reductions] = 100 * (1 - table[reductions] / of_reference[reductions])
    return table
