"""Find a basis of an assembly: modes without contact, or contact-adapted vectors."""

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.structure import modes, structure_file, vtu

logs.write_to(snakemake.log[0])
structure = structure_file.load_structure(snakemake.input.structure)
pod_modes = dataset.load(snakemake.input.pod_modes) if snakemake.input.pod_modes else None
found = modes.find_modes(structure, snakemake.params.family, pod_modes)
dataset.save(found, snakemake.output.modes, snakemake.params)
vtu.write_modes(dataset.load(snakemake.input.assembly), found, snakemake.output.view)
