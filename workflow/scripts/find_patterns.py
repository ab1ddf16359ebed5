"""Find the resonances of the full model while parts of the contact stick."""

from boltjoint import dataset
from boltjoint.structure import patterns
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
found = patterns.resonances(
    dataset.load(snakemake.input.assembly),
    dataset.load(snakemake.input.preload),
    **snakemake.params.options,
)
dataset.save(found, snakemake.output.patterns, snakemake.params)
