"""Mesh an assembly, and assemble its structure."""

from boltjoint import dataset
from boltjoint.config.assembly import Assembly
from boltjoint.config.gap_map import load_gap_map
from boltjoint.structure import structure_file, vtu
from boltjoint.structure.makers.half_lap import mesh, structure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
described = Assembly.model_validate(snakemake.params.assembly)
gap_map = load_gap_map(snakemake.input.gap) if snakemake.input.gap else None
assembly = mesh.build_assembly(described, gap_map)
dataset.save(assembly, snakemake.output.assembly, snakemake.params)
vtu.write_mesh(assembly, snakemake.output.mesh)
of_assembly = structure.structure_of(assembly)
structure_file.save_structure(of_assembly, snakemake.output.structure, snakemake.params)
