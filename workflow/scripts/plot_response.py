"""Draw the frequency responses of a joint over its reference."""

from boltjoint import dataset
from boltjoint.report.figures.responses import plot_response
from boltjoint.report.figures.style import save_figure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
reference = snakemake.input.reference
figure = plot_response(
    dataset.load(snakemake.input.response),
    snakemake.params.joint,
    snakemake.wildcards.coordinates,
    reference=dataset.load(reference) if reference else None,
)
save_figure(figure, snakemake.output.figure)
