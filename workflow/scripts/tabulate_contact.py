"""Tabulate contact pairs, loads and gaps of every preload."""

from boltjoint import dataset
from boltjoint.study.published import Published
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.structure import tabulate_contact
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
preloads = map(dataset.load, snakemake.input.preloads)
table = tabulate_contact(
    dict(zip(snakemake.params.preloads, preloads, strict=True)),
    Published.beside(snakemake.input.published[0]),
)
tables.write(table, snakemake.output.csv, snakemake.output.html, "Contact under bolt preload")
