"""Connect the contact pairs by friction elements."""

from boltjoint import dataset
from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.excitation import place_excitation
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
contact = snakemake.params.contact
modes = place_excitation(
    dataset.load(snakemake.input.assembly),
    dataset.load(snakemake.input.modes),
    snakemake.params.excitation,
    snakemake.params.sensors,
)
connected = connect_nodes(
    modes,
    dataset.load(snakemake.input.preload),
    contact["tangential_stiffness_N_per_m"],
    contact["friction_coefficient"],
    contact.get("normal_stiffness_N_per_m"),
)
dataset.save(joint_to_dataset(connected), snakemake.output.joint, snakemake.params)
