"""Tabulate natural frequencies beside the published ones."""

from boltjoint import dataset
from boltjoint.study.published import Published
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.structure import tabulate_frequencies
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
modes = map(dataset.load, snakemake.input.modes)
table = tabulate_frequencies(
    dict(zip(snakemake.params.assemblies, modes, strict=True)),
    Published.beside(snakemake.input.published[0]),
)
tables.write(
    table, snakemake.output.csv, snakemake.output.html, "Natural frequencies without contact"
)
