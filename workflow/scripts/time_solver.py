"""Time the frequency responses of a joint, alone on the machine."""

from boltjoint.dynamics import frequency_response
from boltjoint.joint.io import load_joint
from boltjoint.solvers.equations import StepControl
from boltjoint.study import timing
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
solved = load_joint(snakemake.input.joint, params.sampling)
window = frequency_response.frequency_window(
    load_joint(snakemake.input.nodes), solved, **params.window
)
times = timing.time_solver(
    solved, window=window, control=StepControl(**params.steps), **params.options
)
times.to_csv(snakemake.output.timing, index=False)
