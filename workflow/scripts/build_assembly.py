"""Mesh an assembly."""

from boltjoint import dataset, logs
from boltjoint.config import Assembly
from boltjoint.structure import export, mesh

logs.write_to(snakemake.log[0])
assembly = mesh.build_assembly(Assembly.model_validate(snakemake.params.assembly))
dataset.save(assembly, snakemake.output.assembly, snakemake.params)
export.write_mesh(assembly, snakemake.output.mesh)
