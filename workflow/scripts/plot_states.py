"""Draw the contact state of every pair at the peak of every force level."""

from boltjoint import dataset
from boltjoint.report.figures.contact import plot_states
from boltjoint.report.figures.style import save_figure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
figure = plot_states(
    *(dataset.load(snakemake.input[name]) for name in ("assembly", "joint", "response"))
)
save_figure(figure, snakemake.output.figure)
