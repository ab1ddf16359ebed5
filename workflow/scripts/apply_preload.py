"""Tighten the bolts of an assembly."""

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.structure import preload as bolt_preload
from boltjoint.structure import structure_file, vtu

logs.write_to(snakemake.log[0])
structure = structure_file.load_structure(snakemake.input.structure)
preload = bolt_preload.apply_preload(structure, snakemake.params.preload)
dataset.save(preload, snakemake.output.preload, snakemake.params)
vtu.write_preload(dataset.load(snakemake.input.assembly), preload, snakemake.output.view)
