"""Solve some of the designs of a sweep, or those that its check solves again."""

from collections.abc import Mapping

from boltjoint import dataset
from boltjoint.config.varied_case import with_values
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.dynamics.response.limits_at_peaks import KnownLimits
from boltjoint.joint.io import ImpossibleJoint, joint_from_dataset, model_errors
from boltjoint.provenance import logs
from boltjoint.solvers.step_control import StepControl
from boltjoint.study.designs import SweptJoint
from boltjoint.study.solved_designs import check_designs, solve_designs

logs.write_to(snakemake.log[0])
params, files = snakemake.params, iter(snakemake.input.joints)
harmonics = HarmonicConvergence(**params.harmonics).up_to(params.highest)


def variant(values: Mapping[str, float], number: int) -> SweptJoint | ImpossibleJoint:
    """The joints of a variant, or why they are impossible."""
    stored = [dataset.load(next(files)) for _ in range(number)]
    try:
        joints = [joint_from_dataset(joint) for joint in stored]
    except ImpossibleJoint as error:
        return error
    case, control = with_values(params.case, values), StepControl(**params.steps)
    # of the node-to-node joint: all of them have its modes
    limits, errors = KnownLimits.of(stored[0]), model_errors(stored[-1])
    return SweptJoint(case, joints, params.sampling, control, harmonics, limits, errors)


variants = [variant(each["values"], each["joints"]) for each in params.variants]
designs = dataset.load(snakemake.input.designs)
threads = snakemake.threads
if "check" in params.keys():
    solved = check_designs(variants, designs, **params.check, threads=threads)
else:
    solved = solve_designs(variants, designs, range(*params.chunk), threads, **params.observed)
dataset.save(solved, snakemake.output[0], params)
