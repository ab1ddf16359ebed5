"""Divide the contact into regions of equal load."""

from boltjoint import dataset, joint, logs, partition

logs.write_to(snakemake.log[0])
nodes = joint.load(snakemake.input.joint)
regions = partition.partition_regions(nodes, snakemake.params.regions)
dataset.save(joint.to_dataset(regions), snakemake.output.joint, snakemake.params)
