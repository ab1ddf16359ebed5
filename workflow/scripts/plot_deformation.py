"""Draw an assembly as its bolts deform it."""

from boltjoint import dataset, figures, logs

logs.write_to(snakemake.log[0])
figure = figures.plot_deformation(
    dataset.load(snakemake.input.assembly), dataset.load(snakemake.input.preload)
)
figures.save(figure, snakemake.output.figure)
