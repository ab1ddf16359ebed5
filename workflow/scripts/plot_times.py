"""Draw the solution times of a case."""

import pandas as pd

from boltjoint import figures, logs

logs.write_to(snakemake.log[0])
times = pd.read_csv(snakemake.input.table)
figure = figures.plot_times(times, int(snakemake.wildcards.resonance))
figures.save(figure, snakemake.output.figure)
