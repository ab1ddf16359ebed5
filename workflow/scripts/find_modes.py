"""Find a modal basis of an assembly: modes without contact, or vectors that hold the contact."""

from boltjoint import dataset, logs
from boltjoint.structure import export, modes

logs.write_to(snakemake.log[0])
assembly = dataset.load(snakemake.input.assembly)
principal = dataset.load(snakemake.input.principal) if snakemake.input.principal else None
found = modes.find_modes(assembly, snakemake.params.family, principal)
dataset.save(found, snakemake.output.modes, snakemake.params)
export.write_modes(assembly, found, snakemake.output.view)
