"""Run CalculiX on an input deck."""

from boltjoint.provenance import logs
from boltjoint.structure.makers.half_lap.calculix import run

logs.write_to(snakemake.log.job)
run(snakemake.input.deck, snakemake.log.program)
