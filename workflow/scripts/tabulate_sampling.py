"""Compare forces sampled in time with the exact ones."""

from boltjoint import convergence, dataset, joint, logs, tables

logs.write_to(snakemake.log[0])
joints = map(joint.load, snakemake.input.joints)
responses = map(dataset.load, snakemake.input.responses)
solved = zip(snakemake.params.cases, zip(joints, responses, strict=True), strict=True)
table = convergence.tabulate_sampling(dict(solved))
tables.write(table, snakemake.output.csv, snakemake.output.html, "Forces sampled in time")
