"""Find the peaks of a joint in the windows that its backbone predicts."""

from boltjoint.joint.io import load_joint
from boltjoint.provenance import logs
from boltjoint.solvers.equations import StepControl
from boltjoint.study import convergence
from boltjoint.study.tables import html as tables

logs.write_to(snakemake.log[0])
control = StepControl(**snakemake.params.steps)
loaded = load_joint(snakemake.input.joint)
found = convergence.peaks_near(loaded, control=control, **snakemake.params.options)
tables.write_data(found, snakemake.output.peaks)
