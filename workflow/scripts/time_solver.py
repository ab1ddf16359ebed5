"""Time the frequency responses of a joint, alone on the machine."""

from boltjoint import joint, logs, response, timing
from boltjoint.continuation import StepControl

logs.write_to(snakemake.log[0])
params, resonance = snakemake.params, int(snakemake.wildcards.resonance)
nodes = joint.load(snakemake.input.nodes)
solved = joint.load(snakemake.input.joint, params.sampling)
times = timing.time_solver(
    solved,
    window=response.frequency_window(nodes, solved, resonance=resonance, given=params.window),
    coordinates=snakemake.wildcards.coordinates,
    resonance=resonance,
    control=StepControl(**params.steps),
    **params.options,
)
times.to_csv(snakemake.output.timing, index=False)
