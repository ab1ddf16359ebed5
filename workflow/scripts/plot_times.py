"""Draw the solution times of a case."""

from boltjoint.report.figures.style import save_figure
from boltjoint.report.figures.times import plot_times
from boltjoint.study.tables import files as tables
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
times = tables.read(snakemake.input.table)
figure = plot_times(times, int(snakemake.wildcards.resonance))
save_figure(figure, snakemake.output.figure)
