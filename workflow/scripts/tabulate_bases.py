"""Compare the peaks of a case in several bases."""

from boltjoint import convergence, logs, tables

logs.write_to(snakemake.log[0])
peaks = map(tables.read, snakemake.input.peaks)
table = convergence.tabulate_basis_peaks(dict(zip(snakemake.params.bases, peaks, strict=True)))
title = f"{snakemake.wildcards.case}: peaks by basis"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
