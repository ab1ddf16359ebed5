"""Fit a few elements to the many of every region."""

from boltjoint import dataset, fitting, joint, logs

logs.write_to(snakemake.log[0])
regions = joint.load(snakemake.input.joint)
reduced, fit = fitting.fit_reduced_joint(regions, **snakemake.params.fit)
result = joint.to_dataset(reduced).merge(fit, combine_attrs="no_conflicts")
dataset.save(result, snakemake.output.joint, snakemake.params)
