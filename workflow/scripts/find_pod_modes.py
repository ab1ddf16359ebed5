"""Find the POD modes of snapshots of an assembly whose contact sticks, slips and opens."""

from boltjoint import dataset
from boltjoint.structure.basis.candidates import BasisOptions
from boltjoint.structure.basis.pod import find_pod_modes
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
found = find_pod_modes(
    dataset.load(snakemake.input.assembly),
    dataset.load(snakemake.input.preload),
    BasisOptions(**params.contact_adapted_basis),
    params.most,
)
dataset.save(found, snakemake.output.principal, params)
