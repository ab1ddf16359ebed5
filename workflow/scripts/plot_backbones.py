"""Draw frequency and damping of the joints of a case over amplitude."""

from boltjoint import dataset
from boltjoint.report.figures.responses import plot_backbones
from boltjoint.report.figures.style import save_figure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
backbones = map(dataset.load, snakemake.input.backbones)
figure = plot_backbones(dict(zip(params.joints, backbones, strict=True)), params.forces)
save_figure(figure, snakemake.output.figure)
