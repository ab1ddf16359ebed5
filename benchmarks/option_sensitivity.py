"""How much peaks move with each numerical option: docs/option_sensitivity.csv.

    python benchmarks/option_sensitivity.py results/cases/CASE/free-4/node-to-node/joint.nc

Each option is halved and doubled while the others keep their defaults.
"""

import sys
from collections.abc import Iterable, Iterator
from dataclasses import fields
from pathlib import Path

import numpy as np
import pandas as pd

from boltjoint import Joint, StepControl, load_joint, solve_branch
from boltjoint.dynamics.response.frequency_response import method_of
from boltjoint.dynamics.response.methods import Method
from boltjoint.solvers.step_control import LaggedControl

OUTPUT = Path(__file__).parents[1] / "docs/option_sensitivity.csv"
LOSS_FACTOR = 0.002
FORCES = (1.0, 10.0, 50.0)
#: those whose peaks solve the equations themselves, and those that keep the error of a held basis
SOLVERS = {
    "equations": (
        method_of("linear"),
        method_of("rdnm-1"),
        method_of("complex-rdnm-1"),
        method_of("backbone"),
    ),
    "held basis": (
        method_of("rdnm-2", basis_update="lagged"),
        method_of("complex-rdnm-1", basis_update="lagged"),
    ),
}


def peaks(joint: Joint, solvers: Iterable[Method], control: StepControl) -> np.ndarray:
    """Frequency and amplitude of every peak, (solvers * forces, 2); NaN without one."""
    found = []
    for solver in solvers:
        for force in FORCES:
            branch = solve_branch(joint, force, solver, damping=LOSS_FACTOR, control=control)
            at = branch.peak
            found.append(
                [np.nan, np.nan] if at is None else [branch.frequency[at], branch.amplitude[at]]
            )
    return np.array(found)


def changed() -> Iterator[tuple[str, str, StepControl]]:
    """Class and name of each option, with a control in which it is halved or doubled."""
    for options in (StepControl, LaggedControl):
        for field in fields(options):
            for factor in (0.5, 2) if isinstance(field.default, int | float) else ():
                value = type(field.default)(field.default * factor)
                try:
                    control = options(**{field.name: value})
                except ValueError:
                    continue  # twice a cosine of a half
                if options is LaggedControl:
                    control = StepControl(lagged=control)
                yield options.__name__, field.name, control


def main(path: str) -> None:
    """Measure on the joint in a file."""
    joint, rows = load_joint(path), []
    for kind, solvers in SOLVERS.items():
        reference = peaks(joint, solvers, StepControl())
        for options, name, control in changed():
            change = np.nanmax(abs(peaks(joint, solvers, control) / reference - 1), axis=0)
            rows.append((options, name, kind, *change))
            print(*rows[-1][:3], *(f"{each:.1e}" for each in change), flush=True)
    columns = ["options", "option", "solvers", "frequency_change", "amplitude_change"]
    table = pd.DataFrame(rows, columns=columns)
    largest = table.groupby(columns[:3], sort=False).max()
    largest.to_csv(OUTPUT, float_format="%.1e")


if __name__ == "__main__":
    main(sys.argv[1])
