"""Draw the mesh of an assembly."""

from boltjoint import dataset
from boltjoint.report.figures.structure import plot_mesh
from boltjoint.report.figures.style import save_figure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
figure = plot_mesh(dataset.load(snakemake.input.assembly))
save_figure(figure, snakemake.output.figure)
