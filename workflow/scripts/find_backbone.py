"""Find natural frequency and damping of a joint over its amplitude."""

from boltjoint import backbone, dataset, joint, logs, response
from boltjoint.solvers.equations import StepControl

logs.write_to(snakemake.log[0])
params = snakemake.params
solved = joint.load(snakemake.input.joint, params.sampling)
window = response.frequency_window(joint.load(snakemake.input.nodes), solved, **params.window)
found = backbone.find_backbone(
    solved, window=window, control=StepControl(**params.steps), **params.options
)
dataset.save(found, snakemake.output.backbone, params)
