"""Draw pressure, normal load and gap over the contact."""

from boltjoint import dataset, figures, logs

logs.write_to(snakemake.log[0])
figure = figures.plot_contact(
    dataset.load(snakemake.input.assembly), dataset.load(snakemake.input.preload)
)
figures.save(figure, snakemake.output.figure)
