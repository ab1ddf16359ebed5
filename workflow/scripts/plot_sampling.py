"""Draw how forces sampled in time approach the exact ones."""

import pandas as pd

from boltjoint import figures, logs

logs.write_to(snakemake.log[0])
figure = figures.plot_sampling(pd.read_csv(snakemake.input.table))
figures.save(figure, snakemake.output.figure)
