"""Draw the error of every model of a case over its cost."""

import pandas as pd

from boltjoint import figures, logs

logs.write_to(snakemake.log[0])
figures.save(figures.plot_models(pd.read_csv(snakemake.input.table)), snakemake.output.figure)
