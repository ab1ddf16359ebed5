"""Draw the hysteresis loops of a region and of the elements fitted to it."""

from boltjoint import dataset
from boltjoint.report.figures.loops import plot_loops
from boltjoint.report.figures.style import save_figure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
figure = plot_loops(
    dataset.load(snakemake.input.reduced),
    dataset.load(snakemake.input.regions),
    snakemake.params.region,
)
save_figure(figure, snakemake.output.figure)
