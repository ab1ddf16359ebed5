"""Draw the mode shapes of an assembly."""

from boltjoint import dataset
from boltjoint.report.figures.structure import plot_modes
from boltjoint.report.figures.style import save_figure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
figure = plot_modes(dataset.load(snakemake.input.assembly), dataset.load(snakemake.input.modes))
save_figure(figure, snakemake.output.figure)
