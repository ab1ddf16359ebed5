"""Tabulate the regions of a joint."""

from boltjoint import dataset
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.joints import tabulate_regions
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
table = tabulate_regions(dataset.load(snakemake.input.joint))
title = f"{snakemake.wildcards.case}: {snakemake.wildcards.regions}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
