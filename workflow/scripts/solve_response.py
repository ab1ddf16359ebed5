"""Compute the frequency responses of a joint."""

from boltjoint import dataset
from boltjoint.dynamics import frequency_response
from boltjoint.joint.io import load_joint
from boltjoint.solvers.equations import StepControl
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
solved = load_joint(snakemake.input.joint, params.sampling)
window = frequency_response.frequency_window(
    load_joint(snakemake.input.nodes), solved, **params.window
)
responses = frequency_response.solve_response(
    solved, window=window, control=StepControl(**params.steps), **params.options
)
dataset.save(responses, snakemake.output.response, params)
