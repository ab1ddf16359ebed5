"""Connect the contact pairs by friction elements."""

import xarray as xr

from boltjoint import dataset
from boltjoint.joint.io import basis_errors_and_limits, joint_to_dataset, save_joint
from boltjoint.joint.node_to_node import connect_pairs
from boltjoint.provenance import logs
from boltjoint.structure.excitation import place_excitation

logs.write_to(snakemake.log[0])
params = snakemake.params
assembly, modes, preload = (
    dataset.load(getattr(snakemake.input, name)) for name in ("assembly", "modes", "preload")
)


def connect() -> xr.Dataset:
    excited = place_excitation(assembly, modes, params.excitation, params.sensors)
    joint = connect_pairs(excited, preload, **params.contact)
    return joint_to_dataset(joint).assign(basis_errors_and_limits(modes))


save_joint(connect, snakemake.output.joint, params, params.of_sweep)
