"""Tabulate the shares of the contact states at the peaks."""

from boltjoint import compare, dataset, logs, tables

logs.write_to(snakemake.log[0])
params = snakemake.params
responses = map(dataset.load, snakemake.input.responses)
joints = map(dataset.load, snakemake.input.joints)
table = compare.tabulate_states(
    dict(zip(params.solved, responses, strict=True)), dict(zip(params.joints, joints, strict=True))
)
title = f"{snakemake.wildcards.case}: contact states at the peaks in {snakemake.wildcards.modes}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
