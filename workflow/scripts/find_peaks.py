"""Find the peaks of a joint in the windows that its backbone predicts."""

from boltjoint import csv_files
from boltjoint.joint.io import load_joint
from boltjoint.provenance import logs
from boltjoint.solvers.step_control import StepControl
from boltjoint.study import convergence

logs.write_to(snakemake.log[0])
control = StepControl(**snakemake.params.steps)
loaded = load_joint(snakemake.input.joint)
found = convergence.peaks_near(loaded, control=control, **snakemake.params.options)
csv_files.write(found, snakemake.output.peaks)
