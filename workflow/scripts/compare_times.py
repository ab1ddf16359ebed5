"""Compare the solution times of a case with each other and with the published ones."""

from boltjoint.study.published import Published
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.times import tabulate_times
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
timings = map(tables.read, snakemake.input.timings)
source = Published.beside(snakemake.input.published[0], snakemake.params.case_study)
table = tabulate_times(dict(zip(snakemake.params.solved, timings, strict=True)), source)
title = f"{snakemake.wildcards.case}: solution times in {snakemake.wildcards.modes}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
