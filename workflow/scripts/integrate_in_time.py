"""Integrate the node-to-node joint in time at its peaks, and balance more harmonics."""

from boltjoint import dataset
from boltjoint.joint.io import load_joint
from boltjoint.study.tables import files as tables
from boltjoint.verification.harmonics_table import tabulate_time_integration
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
solved = load_joint(snakemake.input.joint)
response = dataset.load(snakemake.input.response)
table = tabulate_time_integration(solved, response, forces=snakemake.params.forces)
title = f"{snakemake.wildcards.case}: more harmonics, and time"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
