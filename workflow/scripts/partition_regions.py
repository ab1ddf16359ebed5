"""Partition the contact pairs into regions."""

from boltjoint import dataset
from boltjoint.joint.io import joint_to_dataset, load_joint
from boltjoint.joint.partition import partition_regions
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
nodes = load_joint(snakemake.input.joint)
preload = dataset.load(snakemake.input.preload)
regions = partition_regions(nodes, preload, **snakemake.params.regions)
dataset.save(joint_to_dataset(regions), snakemake.output.joint, snakemake.params)
