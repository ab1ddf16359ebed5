"""Draw where the regions of a joint lie."""

from boltjoint import dataset, figures, logs

logs.write_to(snakemake.log[0])
figure = figures.plot_regions(
    dataset.load(snakemake.input.assembly), dataset.load(snakemake.input.joint)
)
figures.save(figure, snakemake.output.figure)
