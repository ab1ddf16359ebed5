"""Compare the peaks of a joint divided in several ways with those of all its pairs."""

from boltjoint import convergence, dataset, joint, logs, tables
from boltjoint.solvers.equations import StepControl

logs.write_to(snakemake.log[0])
table = convergence.tabulate_divisions(
    joint.load(snakemake.input.joint),
    dataset.load(snakemake.input.preload),
    reference=tables.read(snakemake.input.peaks),
    control=StepControl(**snakemake.params.steps),
    **snakemake.params.options,
)
title = f"{snakemake.wildcards.case}: regions, by way and number"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
