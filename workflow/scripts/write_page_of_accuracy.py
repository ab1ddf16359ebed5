"""Write the page of all models against the converged responses."""

from boltjoint.report.pages import accuracy, markup
from boltjoint.study.published import Published
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
source = Published.beside(snakemake.input.published[0])
page = accuracy.page(snakemake.input.shown, source, snakemake.params.cases)
markup.save(page, snakemake.output.page, snakemake.output.packed)
