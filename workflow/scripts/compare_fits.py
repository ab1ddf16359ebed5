"""Compare the fits of a case's joints: what they cost, and how near they come."""

from boltjoint import dataset
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.joints import tabulate_fits
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
fitted, solved = snakemake.params.fitted, snakemake.params.solved
table = tabulate_fits(
    dict(zip(fitted, map(dataset.load, snakemake.input.fits), strict=True)),
    dict(zip(fitted, map(tables.read, snakemake.input.timings), strict=True)),
    dict(zip(solved, map(dataset.load, snakemake.input.responses), strict=True)),
)
title = f"{snakemake.wildcards.case}: fits of elements"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
