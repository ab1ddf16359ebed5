"""Have CalculiX solve a deck."""

from boltjoint.structure import calculix

calculix.run(snakemake.input.deck, snakemake.log[0])
