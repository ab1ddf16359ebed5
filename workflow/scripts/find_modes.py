"""Find the linear modes of an assembly without contact."""

from boltjoint import dataset, logs
from boltjoint.structure import export, modes

logs.write_to(snakemake.log[0])
assembly = dataset.load(snakemake.input.assembly)
found = modes.find_modes(assembly, snakemake.params.family)
dataset.save(found, snakemake.output.modes, snakemake.params)
export.write_modes(assembly, found, snakemake.output.view)
