"""Time the frequency responses of a joint, alone on the machine."""

from boltjoint import joint, logs, response, timing
from boltjoint.solvers.equations import StepControl

logs.write_to(snakemake.log[0])
params = snakemake.params
solved = joint.load(snakemake.input.joint, params.sampling)
window = response.frequency_window(joint.load(snakemake.input.nodes), solved, **params.window)
times = timing.time_solver(
    solved, window=window, control=StepControl(**params.steps), **params.options
)
times.to_csv(snakemake.output.timing, index=False)
