"""Run CalculiX on an input deck."""

from boltjoint.structure.makers.half_lap.calculix.decks import run
from boltjoint.workflow import logs

logs.write_to(snakemake.log.job)
run(snakemake.input.deck, snakemake.log.program)
