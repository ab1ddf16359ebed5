"""March the node-to-node joint in time, and balance more harmonics, where it responds most."""

from boltjoint import dataset, joint, logs, tables, transient

logs.write_to(snakemake.log[0])
solved = joint.load(snakemake.input.joint)
response = dataset.load(snakemake.input.response)
table = transient.tabulate_truth(solved, response, forces=snakemake.params.forces)
title = f"{snakemake.wildcards.case}: more harmonics, and time"
tables.write(table, snakemake.output.csv, snakemake.output.html, title)
