"""Draw pressure, normal load and gap over the contact."""

from boltjoint import dataset
from boltjoint.report.figures.contact import plot_contact
from boltjoint.report.figures.style import save_figure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
figure = plot_contact(dataset.load(snakemake.input.assembly), dataset.load(snakemake.input.preload))
save_figure(figure, snakemake.output.figure)
