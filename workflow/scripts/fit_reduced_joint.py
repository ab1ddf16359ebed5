"""Fit a few elements to the many of every region."""

import time

import pandas as pd

from boltjoint import dataset, fitting, joint, logs

logs.write_to(snakemake.log[0])
regions = joint.load(snakemake.input.joint)
begun = time.process_time()
reduced, fit = fitting.fit_reduced_joint(regions, **snakemake.params.fit)
pd.DataFrame({"cpu_s": [time.process_time() - begun]}).to_csv(snakemake.output.timing, index=False)
result = joint.to_dataset(reduced).merge(fit, combine_attrs="no_conflicts")
dataset.save(result, snakemake.output.joint, snakemake.params)
