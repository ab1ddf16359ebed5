"""Draw an assembly as its bolts deform it."""

from boltjoint import dataset
from boltjoint.report.figures.structure import plot_deformation
from boltjoint.report.figures.style import save_figure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
figure = plot_deformation(
    dataset.load(snakemake.input.assembly), dataset.load(snakemake.input.preload)
)
save_figure(figure, snakemake.output.figure)
