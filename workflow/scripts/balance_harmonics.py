"""Find the peaks of the node-to-node joint with more and more harmonics."""

from boltjoint import dataset, joint, logs, manyharmonics, tables

logs.write_to(snakemake.log[0])
solved = joint.load(snakemake.input.joint)
response = dataset.load(snakemake.input.response)
table = manyharmonics.tabulate_peaks(solved, response, forces=snakemake.params.forces)
title = f"{snakemake.wildcards.case}: peaks with more harmonics, in {snakemake.wildcards.modes}"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
