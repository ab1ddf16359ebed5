"""Time the frequency responses of a joint, alone on the machine."""

from boltjoint import joint, logs, response, timing
from boltjoint.continuation import StepControl

logs.write_to(snakemake.log[0])
params, resonance = snakemake.params, int(snakemake.wildcards.resonance)
nodes = joint.load(snakemake.input.nodes)
times = timing.time_solver(
    joint.load(snakemake.input.joint),
    window=response.frequency_window(nodes, resonance, params.window),
    coordinates=snakemake.wildcards.coordinates,
    resonance=resonance,
    control=StepControl(**params.steps),
    **params.options,
)
times.to_csv(snakemake.output.timing, index=False)
