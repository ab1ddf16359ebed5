"""Tabulate the resonances of bases while parts of the contact stick."""

from boltjoint import dataset
from boltjoint.study import convergence
from boltjoint.study.tables import files as tables
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
modes = map(dataset.load, snakemake.input.modes)
table = convergence.tabulate_patterns(
    dict(zip(snakemake.params.bases, modes, strict=True)),
    dataset.load(snakemake.input.patterns),
)
title = f"{snakemake.wildcards.assembly}: resonances while parts of the contact stick"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
