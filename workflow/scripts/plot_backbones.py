"""Draw frequency and damping of the joints of a case over amplitude."""

from boltjoint import dataset, figures, logs

logs.write_to(snakemake.log[0])
params = snakemake.params
backbones = map(dataset.load, snakemake.input.backbones)
figure = figures.plot_backbones(dict(zip(params.joints, backbones, strict=True)), params.forces)
figures.save(figure, snakemake.output.figure)
