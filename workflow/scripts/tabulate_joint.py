"""Replace the elements of every region by one table."""

from boltjoint import dataset
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.joint.reduced import tabulate_joint
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
stored = dataset.load(snakemake.input.joint)
tabulated = tabulate_joint(joint_from_dataset(stored))
dataset.save(joint_to_dataset(tabulated, stored), snakemake.output.joint, snakemake.params)
