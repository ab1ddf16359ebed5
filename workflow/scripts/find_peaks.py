"""Find the peaks of a joint, following its responses only where they are expected."""

from boltjoint import convergence, joint, logs
from boltjoint.solvers.equations import StepControl

logs.write_to(snakemake.log[0])
control = StepControl(**snakemake.params.steps)
loaded = joint.load(snakemake.input.joint)
found = convergence.peaks_near(loaded, control=control, **snakemake.params.options)
found.to_csv(snakemake.output.peaks, index=False)
