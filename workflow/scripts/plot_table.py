"""Draw a table."""

from boltjoint.report.figures.convergence import (
    plot_bases,
    plot_divisions,
    plot_models,
    plot_patterns,
    plot_sampling,
)
from boltjoint.report.figures.style import save_figure
from boltjoint.study.tables import files as tables
from boltjoint.workflow import logs

DRAW = {
    "bases": plot_bases,
    "divisions": plot_divisions,
    "models": plot_models,
    "patterns": plot_patterns,
    "sampling": plot_sampling,
}

logs.write_to(snakemake.log[0])
kind = snakemake.wildcards.drawn.partition("_")[0]
save_figure(DRAW[kind](tables.read(snakemake.input.table)), snakemake.output.figure)
