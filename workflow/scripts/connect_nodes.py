"""Connect the contact pairs by friction elements."""

from boltjoint import dataset
from boltjoint.friction.laws import LAWS
from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.node_to_node import connect_pairs
from boltjoint.structure.excitation import place_excitation
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
modes = place_excitation(
    dataset.load(snakemake.input.assembly),
    dataset.load(snakemake.input.modes),
    snakemake.params.excitation,
    snakemake.params.sensors,
)
keys, preload = dict(snakemake.params.contact), dataset.load(snakemake.input.preload)
connected = connect_pairs(modes, preload, LAWS[keys.pop("law")], **keys)
dataset.save(joint_to_dataset(connected), snakemake.output.joint, snakemake.params)
