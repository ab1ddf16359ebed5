"""Draw where the regions of a joint lie."""

from boltjoint import dataset
from boltjoint.report.figures.contact import plot_regions
from boltjoint.report.figures.style import save_figure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
figure = plot_regions(dataset.load(snakemake.input.assembly), dataset.load(snakemake.input.joint))
save_figure(figure, snakemake.output.figure)
