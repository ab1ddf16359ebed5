"""Solve some of the designs of a sweep, or those that its check solves again."""

from collections.abc import Mapping

from boltjoint import dataset
from boltjoint.config.varied_case import with_values
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.joint.io import ImpossibleJoint
from boltjoint.provenance import logs
from boltjoint.solvers.step_control import StepControl
from boltjoint.study.designs import SweptJoint
from boltjoint.study.solved_designs import check_designs, solve_designs

logs.write_to(snakemake.log[0])
params, files = snakemake.params, iter(snakemake.input.joints)
harmonics = HarmonicConvergence(**params.harmonics).up_to(params.highest)
control = StepControl(**params.steps)


def variant(values: Mapping[str, float], number: int) -> SweptJoint | ImpossibleJoint:
    """The joints of a variant, or why they are impossible."""
    case = with_values(params.case, values)
    stored = [dataset.load(next(files)) for _ in range(number)]
    try:
        return SweptJoint.of_datasets(case, stored, params.sampling, control, harmonics)
    except ImpossibleJoint as error:
        return error


variants = [variant(each["values"], each["joints"]) for each in params.variants]
designs = dataset.load(snakemake.input.designs)
threads = snakemake.threads
if "check" in params.keys():
    solved = check_designs(variants, designs, **params.check, threads=threads)
else:
    solved = solve_designs(variants, designs, range(*params.chunk), threads, **params.observed)
dataset.save(solved, snakemake.output[0], params)
