"""Solve some of the designs of a sweep."""

from boltjoint import dataset
from boltjoint.config.varied_case import with_values
from boltjoint.joint.io import load_joint
from boltjoint.solvers.equations import StepControl
from boltjoint.study.sweeps import SweptJoint, solve_designs
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params, files = snakemake.params, iter(snakemake.input.joints)
variants = [
    SweptJoint(
        with_values(params.case, variant["values"]),
        [load_joint(next(files)) for _ in range(variant["joints"])],
        params.sampling,
        StepControl(**params.steps),
    )
    for variant in params.variants
]
designs = dataset.load(snakemake.input.designs)
how = {"threads": snakemake.threads, **params.observed}
solved = solve_designs(variants, designs, range(*params.chunk), **how)
dataset.save(solved, snakemake.output.chunk, params)
