"""Partition the contact pairs into regions."""

from boltjoint import dataset
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.slip_states import SlipStateOptions
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
stored = dataset.load(snakemake.input.joint)
preload = dataset.load(snakemake.input.preload)
nodes, options = joint_from_dataset(stored), SlipStateOptions()
regions = partition_regions(nodes, preload, **snakemake.params.regions, options=options)
result = joint_to_dataset(regions, stored).assign_attrs(options=options.stored())
dataset.save(result, snakemake.output.joint, snakemake.params)
