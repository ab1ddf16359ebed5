"""Let a few contact pairs, with weights, stand for all."""

from boltjoint import dataset
from boltjoint.dynamics.hyper_reduction import weigh_pairs
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.solvers.equations import StepControl
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
stored = dataset.load(snakemake.input.joint)
problem = snakemake.params.problem
weighted, fit = weigh_pairs(
    joint_from_dataset(stored),
    problem["forces"],
    problem["damping"],
    windows=problem["windows"],
    control=StepControl(**problem["steps"]),
    **snakemake.params.accuracy,
)
result = joint_to_dataset(weighted, stored).merge(fit, combine_attrs="no_conflicts")
dataset.save(result, snakemake.output.joint, snakemake.params)
