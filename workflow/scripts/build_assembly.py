"""Make an assembly, and assemble its structure."""

from pathlib import Path

from boltjoint import dataset
from boltjoint.config.makers import description_of
from boltjoint.provenance import logs
from boltjoint.structure import structure_file, vtu
from boltjoint.structure.makers import registry

logs.write_to(snakemake.log[0])
described = description_of(snakemake.params.assembly)
assembly, structure = registry.make(described, Path.cwd())
dataset.save(assembly, snakemake.output.assembly, snakemake.params)
vtu.write_mesh(assembly, snakemake.output.mesh)
structure_file.save_structure(structure, snakemake.output.structure, snakemake.params)
