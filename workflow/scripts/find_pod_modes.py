"""Find the POD modes of snapshots of an assembly whose contact sticks, slips and opens."""

from boltjoint import dataset
from boltjoint.config.contact_adapted_basis import ContactAdaptedBasis
from boltjoint.structure.basis.pod import find_pod_modes
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
found = find_pod_modes(
    dataset.load(snakemake.input.assembly),
    dataset.load(snakemake.input.preload),
    ContactAdaptedBasis(**snakemake.params.contact_adapted_basis),
)
dataset.save(found, snakemake.output.pod_modes, snakemake.params)
