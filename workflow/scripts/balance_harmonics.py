"""Find the peaks of the node-to-node joint with increasing numbers of harmonics."""

from boltjoint import dataset
from boltjoint.joint.io import load_joint
from boltjoint.study.tables import files as tables
from boltjoint.verification import multi_harmonic
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
solved = load_joint(snakemake.input.joint)
response = dataset.load(snakemake.input.response)
table = multi_harmonic.tabulate_peaks(solved, response, forces=snakemake.params.forces)
title = f"{snakemake.wildcards.case}: peaks with more harmonics, in {snakemake.wildcards.basis}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
