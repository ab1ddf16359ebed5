"""Tabulate the regions of a joint."""

from boltjoint import compare, dataset, logs, tables

logs.write_to(snakemake.log[0])
table = compare.tabulate_regions(dataset.load(snakemake.input.joint))
title = f"{snakemake.wildcards.case}: {snakemake.wildcards.regions}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
