"""Tabulate contact pairs, loads and gaps of every preload."""

from boltjoint import compare, dataset, logs, tables
from boltjoint.published import Published

logs.write_to(snakemake.log[0])
preloads = map(dataset.load, snakemake.input.preloads)
table = compare.tabulate_contact(
    dict(zip(snakemake.params.preloads, preloads, strict=True)),
    Published.beside(snakemake.input.published[0]),
)
tables.write(table, snakemake.output.csv, snakemake.output.html, "Contact under bolt preload")
