"""Replace the elements of every region by one table."""

from boltjoint import dataset
from boltjoint.joint.io import joint_to_dataset, load_joint
from boltjoint.joint.reduced import tabulate_joint
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
tabulated = tabulate_joint(load_joint(snakemake.input.joint))
dataset.save(joint_to_dataset(tabulated), snakemake.output.joint, snakemake.params)
