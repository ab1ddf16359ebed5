"""Tabulate the errors of regions over their number and division."""

from boltjoint import dataset
from boltjoint.joint.io import load_joint
from boltjoint.solvers.equations import StepControl
from boltjoint.study import convergence
from boltjoint.study.tables import files as tables
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
table = convergence.tabulate_divisions(
    load_joint(snakemake.input.joint),
    dataset.load(snakemake.input.preload),
    reference=tables.read(snakemake.input.peaks),
    control=StepControl(**snakemake.params.steps),
    **snakemake.params.options,
)
title = f"{snakemake.wildcards.case}: regions, by way and number"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
