"""Replace the elements of every region by those of a reduction."""

import time

import pandas as pd

from boltjoint import dataset
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.joint.reductions import reduce_joint
from boltjoint.study.tables import files as tables
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
stored = dataset.load(snakemake.input.joint)
regions = joint_from_dataset(stored)
begun = time.process_time()
reduced, fit = reduce_joint(regions, **snakemake.params.reduction)
timing = pd.DataFrame({"cpu_s": [time.process_time() - begun]})
tables.write_data(timing, snakemake.output.timing)
result = joint_to_dataset(reduced, stored).merge(fit, combine_attrs="no_conflicts")
dataset.save(result, snakemake.output.joint, snakemake.params)
