"""Tabulate natural frequencies beside the published ones."""

from boltjoint import compare, dataset, logs, tables
from boltjoint.published import Published

logs.write_to(snakemake.log[0])
modes = map(dataset.load, snakemake.input.modes)
table = compare.tabulate_frequencies(
    dict(zip(snakemake.params.assemblies, modes, strict=True)),
    Published.beside(snakemake.input.published[0]),
)
tables.write(
    table, snakemake.output.csv, snakemake.output.html, "Natural frequencies without contact"
)
