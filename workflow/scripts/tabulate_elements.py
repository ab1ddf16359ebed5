"""Tabulate the elements of a reduced joint beside the published ones."""

from boltjoint import dataset
from boltjoint.study.published import Published
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.joints import tabulate_elements
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
table = tabulate_elements(
    dataset.load(snakemake.input.joint),
    snakemake.params.joint,
    Published.beside(snakemake.input.published[0], snakemake.params.case_study),
)
title = f"{snakemake.wildcards.case}: elements of {snakemake.params.joint}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
