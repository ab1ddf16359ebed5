"""Find a basis of an assembly: modes without contact, or contact-adapted vectors."""

from boltjoint import dataset
from boltjoint.structure import modes, vtu
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
assembly = dataset.load(snakemake.input.assembly)
principal = dataset.load(snakemake.input.principal) if snakemake.input.principal else None
found = modes.find_modes(assembly, snakemake.params.family, principal)
dataset.save(found, snakemake.output.modes, snakemake.params)
vtu.write_modes(assembly, found, snakemake.output.view)
