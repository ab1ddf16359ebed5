"""Find the POD modes of an assembly for the contact and damping of its cases."""

from boltjoint import dataset
from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.provenance import logs
from boltjoint.structure.structure_file import load_structure

logs.write_to(snakemake.log[0])
found = find_pod_modes(
    load_structure(snakemake.input.structure),
    dataset.load(snakemake.input.preload),
    [ContactCondition.of(**condition) for condition in snakemake.params.conditions],
    ContactAdaptedBasis(**snakemake.params.contact_adapted_basis),
)
dataset.save(found, snakemake.output.pod_modes, snakemake.params)
