"""Tabulate the shares of the contact states at the peaks."""

from boltjoint import dataset
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.joints import tabulate_states
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
responses = map(dataset.load, snakemake.input.responses)
joints = map(dataset.load, snakemake.input.joints)
table = tabulate_states(
    dict(zip(params.solved, responses, strict=True)), dict(zip(params.joints, joints, strict=True))
)
title = f"{snakemake.wildcards.case}: contact states at the peaks in {snakemake.wildcards.modes}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
