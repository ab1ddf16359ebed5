"""Draw the solution times of a case."""

from boltjoint import figures, logs, tables

logs.write_to(snakemake.log[0])
times = tables.read(snakemake.input.table)
figure = figures.plot_times(times, int(snakemake.wildcards.resonance))
figures.save(figure, snakemake.output.figure)
