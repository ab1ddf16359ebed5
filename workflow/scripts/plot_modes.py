"""Draw the mode shapes of an assembly."""

from boltjoint import dataset, figures, logs

logs.write_to(snakemake.log[0])
figure = figures.plot_modes(
    dataset.load(snakemake.input.assembly), dataset.load(snakemake.input.modes)
)
figures.save(figure, snakemake.output.figure)
