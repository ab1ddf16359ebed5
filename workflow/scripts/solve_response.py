"""Compute the frequency responses of a joint."""

from boltjoint import dataset, joint, logs, response
from boltjoint.continuation import StepControl

logs.write_to(snakemake.log[0])
params, resonance = snakemake.params, int(snakemake.wildcards.resonance)
nodes = joint.load(snakemake.input.nodes)
solved = joint.load(snakemake.input.joint, params.sampling)
responses = response.solve_response(
    solved,
    window=response.frequency_window(nodes, solved, resonance=resonance, given=params.window),
    coordinates=snakemake.wildcards.coordinates,
    resonance=resonance,
    control=StepControl(**params.steps),
    **params.options,
)
dataset.save(responses, snakemake.output.response, params)
