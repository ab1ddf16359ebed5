"""Whether the errors that a finished sweep states hold for designs that its check did not see.

    python benchmarks/unseen_designs.py --sweep three_bolt_uncertainty --count 40 --seed 1

draws designs at random, without those that tell the errors, and solves their peaks again in the
model of the check with as many harmonics, without error bars of their own.
"""

import argparse
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr

from boltjoint import dataset
from boltjoint.calibration.forked_map import forked_map
from boltjoint.config.study import load_study
from boltjoint.config.varied_case import with_values
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.solvers.step_control import StepControl
from boltjoint.study import layout
from boltjoint.study.artefact_list import Contents
from boltjoint.study.designs import SweptJoint
from boltjoint.study.errors_of_sweep import QUANTITIES, errors_by_level, peak_variable
from boltjoint.study.solved_designs import solve_designs

ROOT = Path(__file__).parents[1]
PROCESSES = 2


def main() -> None:
    """Solve designs of a sweep again, and print how far they are off and what was stated."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--study", default="config/sweeps.yaml", help="file of the study")
    parser.add_argument("--sweep", default="three_bolt_uncertainty", help="name of the sweep")
    parser.add_argument("--count", type=int, default=40, help="designs that are drawn")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random numbers")
    given = parser.parse_args()
    name = given.sweep
    study = load_study(ROOT, {"study": given.study})
    sweep = dataset.load(ROOT / layout.path("sweep", sweep=name))
    designs = dataset.load(ROOT / layout.path("designs", sweep=name))
    check = study.sweeps[name].check
    if check is None or study.sweeps[name].grid:
        parser.error(f"{name} must have a check, and no grid")
    unseen = designs["reason"].to_numpy() == ""
    unseen[sweep["checked_design"].to_numpy()] = False
    if "is_predicted" in sweep:
        unseen &= sweep["is_predicted"].to_numpy() == 1
    random = np.random.default_rng(given.seed)
    rows = np.flatnonzero(unseen)
    rows = np.sort(random.choice(rows, min(given.count, rows.size), replace=False))
    drawn = designs.isel(design=rows)
    harmonics = HarmonicConvergence(**study.solver.harmonic_convergence).up_to(check.harmonics)
    control, base = StepControl(**study.solver.steps), study.base_of_sweep(name, checking=True)
    variants = [
        SweptJoint.of_datasets(
            with_values(base, variant.values),
            [dataset.load(ROOT / file) for file in files],
            study.solver.sampling,
            control,
            harmonics,
        )
        for variant, files in zip(
            study.possible_variants(name),
            Contents(study).joints_of_sweep(name, checking=True),
            strict=True,
        )
    ]
    solve = partial(_solve, variants, drawn)
    found = list(forked_map(solve, list(range(rows.size)), PROCESSES))
    stated = errors_by_level(sweep)
    for what in QUANTITIES:
        own = sweep[peak_variable(sweep, what)].to_numpy()[rows].reshape(rows.size, -1)
        ratio = own / np.array([peaks[what] for peaks in found])
        off = np.maximum(ratio, 1 / ratio) - 1
        for level, error in enumerate(stated[what]):
            known = off[np.isfinite(off[:, level]), level]
            print(
                f"{what}, level {level + 1}: {(known <= error).sum()} of {known.size} within the "
                f"stated {100 * error:.2g} %: median {100 * np.median(known):.2g} %, largest "
                f"{100 * known.max():.2g} %; {rows.size - known.size} have no peak"
            )


def _solve(variants: list[SweptJoint], drawn: xr.Dataset, place: int) -> dict[str, np.ndarray]:
    """Peaks of a design in the larger model."""
    options = {"converged": True, "error_bars": False}
    peaks = solve_designs(variants, drawn.isel(design=[place]), range(1), **options)
    return {what: peaks[f"peak_{what}_converged"].to_numpy()[0] for what in QUANTITIES}


if __name__ == "__main__":
    main()
