"""Draw the frequency responses of a joint over its reference."""

from boltjoint import dataset, figures, logs

logs.write_to(snakemake.log[0])
reference = snakemake.input.reference
figure = figures.plot_response(
    dataset.load(snakemake.input.response),
    snakemake.params.joint,
    snakemake.wildcards.coordinates,
    reference=dataset.load(reference) if reference else None,
)
figures.save(figure, snakemake.output.figure)
