"""Partition the contact pairs into regions."""

import xarray as xr

from boltjoint import dataset
from boltjoint.joint.clusters import SlipStateOptions
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset, save_joint
from boltjoint.joint.partition import partition_regions
from boltjoint.provenance import logs

logs.write_to(snakemake.log[0])
params, options = snakemake.params, SlipStateOptions()
stored = dataset.load(snakemake.input.joint)
preload = dataset.load(snakemake.input.preload)


def partition() -> xr.Dataset:
    nodes = joint_from_dataset(stored)
    regions = partition_regions(nodes, preload, **params.regions, options=options)
    return joint_to_dataset(regions, stored).assign_attrs(options=options.stored())


save_joint(partition, snakemake.output.joint, params, params.of_sweep)
