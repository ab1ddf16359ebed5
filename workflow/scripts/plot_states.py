"""Draw the contact state of every pair at the peak of every force level."""

from boltjoint import dataset, figures, logs

logs.write_to(snakemake.log[0])
figure = figures.plot_states(
    *(dataset.load(snakemake.input[name]) for name in ("assembly", "joint", "response"))
)
figures.save(figure, snakemake.output.figure)
