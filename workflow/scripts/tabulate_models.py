"""Tabulate the errors and costs of all models of a case."""

from boltjoint import dataset
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.accuracy import tabulate_models
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
which = [tuple(each) for each in snakemake.params.compared]
responses = map(dataset.load, snakemake.input.responses)
timings = map(tables.read, snakemake.input.timings)
table = tabulate_models(
    dict(zip(which, responses, strict=True)),
    dict(zip(which, timings, strict=True)),
    tuple(snakemake.params.converged),
)
title = f"{snakemake.wildcards.case}: all models against the converged response"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
