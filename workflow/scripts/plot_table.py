"""Draw a table."""

from boltjoint import figures, logs, tables

DRAW = {
    "bases": figures.plot_bases,
    "divisions": figures.plot_divisions,
    "models": figures.plot_models,
    "patterns": figures.plot_patterns,
    "sampling": figures.plot_sampling,
}

logs.write_to(snakemake.log[0])
kind = snakemake.wildcards.drawn.partition("_")[0]
figures.save(DRAW[kind](tables.read(snakemake.input.table)), snakemake.output.figure)
