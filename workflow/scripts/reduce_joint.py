"""Replace the elements of every region by those of a reduction."""

import time

import pandas as pd
import xarray as xr

from boltjoint import csv_files, dataset
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset, save_joint
from boltjoint.joint.reductions import reduce_joint
from boltjoint.provenance import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
stored, taken = dataset.load(snakemake.input.joint), []


def reduce() -> xr.Dataset:
    regions = joint_from_dataset(stored)
    begun = time.process_time()
    reduced, fit = reduce_joint(regions, **params.reduction)
    taken.append(time.process_time() - begun)
    return joint_to_dataset(reduced, stored, fit)


save_joint(reduce, snakemake.output.joint, params, params.of_sweep)
csv_files.write(pd.DataFrame({"cpu_s": taken}), snakemake.output.timing)
