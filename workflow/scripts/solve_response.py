"""Compute the frequency responses of a joint."""

from boltjoint import dataset, joint, logs, response
from boltjoint.solvers.equations import StepControl

logs.write_to(snakemake.log[0])
params = snakemake.params
solved = joint.load(snakemake.input.joint, params.sampling)
window = response.frequency_window(joint.load(snakemake.input.nodes), solved, **params.window)
responses = response.solve_response(
    solved, window=window, control=StepControl(**params.steps), **params.options
)
dataset.save(responses, snakemake.output.response, params)
