"""Tabulate the elements of a reduced joint beside the published ones."""

from boltjoint import compare, dataset, logs, tables
from boltjoint.published import Published

logs.write_to(snakemake.log[0])
table = compare.tabulate_elements(
    dataset.load(snakemake.input.joint),
    snakemake.params.joint,
    Published.beside(snakemake.input.published[0], snakemake.params.case_study),
)
title = f"{snakemake.wildcards.case}: elements of {snakemake.params.joint}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
