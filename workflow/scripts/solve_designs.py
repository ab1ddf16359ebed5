"""Solve some of the designs of a sweep."""

from collections.abc import Mapping

from boltjoint import dataset
from boltjoint.config.varied_case import with_values
from boltjoint.joint.io import ImpossibleJoint, load_joint
from boltjoint.provenance import logs
from boltjoint.solvers.equations import StepControl
from boltjoint.study.sweeps import solve_designs
from boltjoint.study.swept_joint import SweptJoint

logs.write_to(snakemake.log[0])
params, files = snakemake.params, iter(snakemake.input.joints)


def variant(values: Mapping[str, float], number: int) -> SweptJoint | ImpossibleJoint:
    """The joints of a variant, or why they are impossible."""
    joints = [next(files) for _ in range(number)]
    try:
        joints = [load_joint(file) for file in joints]
    except ImpossibleJoint as error:
        return error
    case = with_values(params.case, values)
    return SweptJoint(case, joints, params.sampling, StepControl(**params.steps))


variants = [variant(each["values"], each["joints"]) for each in params.variants]
designs = dataset.load(snakemake.input.designs)
how = {"threads": snakemake.threads, **params.observed}
solved = solve_designs(variants, designs, range(*params.chunk), **how)
dataset.save(solved, snakemake.output.chunk, params)
