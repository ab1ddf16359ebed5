"""Solve some of the designs of a sweep."""

from boltjoint import dataset
from boltjoint.joint.io import load_joint
from boltjoint.solvers.equations import StepControl
from boltjoint.study.sweeps import SweptJoint, solve_designs
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params, joints = snakemake.params, [load_joint(path) for path in snakemake.input.joints]
problem = SweptJoint(params.case, joints, params.sampling, StepControl(**params.steps))
designs = dataset.load(snakemake.input.designs)
solved = solve_designs(problem, designs, range(*params.chunk), snakemake.threads, **params.observed)
dataset.save(solved, snakemake.output.chunk, params)
