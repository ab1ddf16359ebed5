"""Mesh an assembly."""

from boltjoint import dataset
from boltjoint.config.assembly import Assembly
from boltjoint.structure import vtu
from boltjoint.structure.half_lap import mesh
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
assembly = mesh.build_assembly(Assembly.model_validate(snakemake.params.assembly))
dataset.save(assembly, snakemake.output.assembly, snakemake.params)
vtu.write_mesh(assembly, snakemake.output.mesh)
