"""Partition the contact pairs into regions."""

from boltjoint import dataset
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.joint.partition import partition_regions
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
stored = dataset.load(snakemake.input.joint)
preload = dataset.load(snakemake.input.preload)
regions = partition_regions(joint_from_dataset(stored), preload, **snakemake.params.regions)
dataset.save(joint_to_dataset(regions, stored), snakemake.output.joint, snakemake.params)
