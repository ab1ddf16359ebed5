"""Let a table stand for all elements of every region."""

from boltjoint import dataset, fitting, joint, logs

logs.write_to(snakemake.log[0])
tabulated = fitting.tabulate_joint(joint.load(snakemake.input.joint))
dataset.save(joint.to_dataset(tabulated), snakemake.output.joint, snakemake.params)
