"""Draw the mesh of an assembly."""

from boltjoint import dataset, figures, logs

logs.write_to(snakemake.log[0])
figure = figures.plot_mesh(dataset.load(snakemake.input.assembly))
figures.save(figure, snakemake.output.figure)
