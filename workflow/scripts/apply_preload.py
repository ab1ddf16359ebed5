"""Tighten the bolts of an assembly."""

from boltjoint import dataset
from boltjoint.structure import preload as bolt_preload
from boltjoint.structure import vtu
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
assembly = dataset.load(snakemake.input.assembly)
preload = bolt_preload.apply_preload(assembly, snakemake.params.preload)
dataset.save(preload, snakemake.output.preload, snakemake.params)
vtu.write_preload(assembly, preload, snakemake.output.view)
