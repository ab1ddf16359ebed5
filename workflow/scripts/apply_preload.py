"""Tighten the bolts of an assembly."""

from boltjoint import dataset, logs
from boltjoint.structure import export, statics

logs.write_to(snakemake.log[0])
assembly = dataset.load(snakemake.input.assembly)
preload = statics.apply_preload(assembly, snakemake.params.preload)
dataset.save(preload, snakemake.output.preload, snakemake.params)
export.write_preload(assembly, preload, snakemake.output.view)
