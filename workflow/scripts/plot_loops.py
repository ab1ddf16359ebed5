"""Draw the hysteresis loops of a region and of the elements fitted to it."""

from boltjoint import dataset, figures, logs

logs.write_to(snakemake.log[0])
figure = figures.plot_loops(
    dataset.load(snakemake.input.reduced),
    dataset.load(snakemake.input.regions),
    snakemake.params.region,
)
figures.save(figure, snakemake.output.figure)
