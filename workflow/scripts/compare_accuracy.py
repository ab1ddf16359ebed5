"""Compare every response of a case with the node-to-node joint in linear modes."""

from boltjoint import dataset
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.accuracy import tabulate_accuracy
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
responses = map(dataset.load, snakemake.input.responses)
checks = map(tables.read, snakemake.input.checks)
table = tabulate_accuracy(
    dict(zip(snakemake.params.solved, responses, strict=True)),
    dict(zip(snakemake.params.checked, checks, strict=True)),
)
title = f"{snakemake.wildcards.case}: accuracy in {snakemake.wildcards.modes}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
