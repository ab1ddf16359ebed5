"""Gather the pairs of the contact in regions."""

from boltjoint import dataset, joint, logs, partition

logs.write_to(snakemake.log[0])
nodes = joint.load(snakemake.input.joint)
preload = dataset.load(snakemake.input.preload)
regions = partition.partition_regions(nodes, preload, **snakemake.params.regions)
dataset.save(joint.to_dataset(regions), snakemake.output.joint, snakemake.params)
