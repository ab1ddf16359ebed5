"""Run CalculiX on an input deck."""

from boltjoint.provenance import logs
from boltjoint.structure.calculix_program import run

logs.write_to(snakemake.log.job)
run(snakemake.input.deck, snakemake.log.program)
