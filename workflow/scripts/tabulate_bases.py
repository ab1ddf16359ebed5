"""Tabulate the peaks of a case over its bases."""

from boltjoint.study import convergence
from boltjoint.study.tables import files as tables
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
peaks = map(tables.read, snakemake.input.peaks)
table = convergence.tabulate_basis_peaks(dict(zip(snakemake.params.bases, peaks, strict=True)))
title = f"{snakemake.wildcards.case}: peaks by basis"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
