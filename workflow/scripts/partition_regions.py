"""Divide the contact into regions along the bar."""

from boltjoint import dataset, joint, logs, partition

logs.write_to(snakemake.log[0])
nodes = joint.load(snakemake.input.joint)
preload = dataset.load(snakemake.input.preload)
params = snakemake.params
regions = partition.partition_regions(nodes, preload, params.regions, params.division)
dataset.save(joint.to_dataset(regions), snakemake.output.joint, snakemake.params)
