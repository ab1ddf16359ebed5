"""Have CalculiX solve a deck."""

from boltjoint import logs
from boltjoint.structure import calculix

logs.write_to(snakemake.log.job)
calculix.run(snakemake.input.deck, snakemake.log.program)
