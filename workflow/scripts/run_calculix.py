"""Run CalculiX on an input deck."""

from boltjoint.provenance import logs
from boltjoint.structure.calculix_program import run_if_possible

logs.write_to(snakemake.log.job)
run_if_possible(snakemake.input.deck, snakemake.log.program)
