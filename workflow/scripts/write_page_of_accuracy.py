"""Write the page of the accuracy of all models."""

from boltjoint.report.pages.accuracy import accuracy_page
from boltjoint.report.pages.document import save_page
from boltjoint.study.published import Published
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
source = Published.beside(snakemake.input.published[0])
page = accuracy_page(snakemake.input.shown, source, snakemake.params.cases)
save_page(page, snakemake.output.page, snakemake.output.packed)
