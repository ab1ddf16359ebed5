"""Gather all designs of a sweep in one dataset."""

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.study.solved_designs import gather_sweep

logs.write_to(snakemake.log[0])
params, designs = snakemake.params, dataset.load(snakemake.input.designs)
chunks = [dataset.load(path) for path in snakemake.input.chunks]
check = [dataset.load(path) for path in snakemake.input.check]
sweep = gather_sweep(params.case, designs, chunks, params.grid, *check)
dataset.save(sweep, snakemake.output.sweep, params)
