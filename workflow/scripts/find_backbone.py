"""Find natural frequency and damping of a joint over its amplitude."""

from boltjoint import dataset
from boltjoint.dynamics import frequency_response
from boltjoint.dynamics.epmc import find_backbone
from boltjoint.joint.io import load_joint
from boltjoint.solvers.equations import StepControl
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
solved = load_joint(snakemake.input.joint, params.sampling)
window = frequency_response.frequency_window(
    load_joint(snakemake.input.nodes), solved, **params.window
)
found = find_backbone(solved, window=window, control=StepControl(**params.steps), **params.options)
dataset.save(found, snakemake.output.backbone, params)
