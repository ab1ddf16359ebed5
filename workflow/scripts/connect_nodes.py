"""Put friction elements on the contact pairs."""

from boltjoint import dataset, joint, logs

logs.write_to(snakemake.log[0])
contact = snakemake.params.contact
connected = joint.connect_nodes(
    dataset.load(snakemake.input.modes),
    dataset.load(snakemake.input.preload),
    contact["tangential_stiffness_N_per_m"],
    contact["friction_coefficient"],
    contact.get("normal_stiffness_N_per_m"),
)
dataset.save(joint.to_dataset(connected), snakemake.output.joint, snakemake.params)
