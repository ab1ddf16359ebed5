"""Compute the frequency responses of a joint."""

from boltjoint import dataset, joint, logs, response
from boltjoint.continuation import StepControl

logs.write_to(snakemake.log[0])
params, resonance = snakemake.params, int(snakemake.wildcards.resonance)
nodes = joint.load(snakemake.input.nodes)
solved = response.solve_response(
    joint.load(snakemake.input.joint),
    window=response.frequency_window(nodes, resonance, params.window),
    coordinates=snakemake.wildcards.coordinates,
    resonance=resonance,
    control=StepControl(**params.steps),
    **params.options,
)
dataset.save(solved, snakemake.output.response, params)
