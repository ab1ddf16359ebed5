"""Write the page of the accuracy of all models."""

from boltjoint.provenance import logs
from boltjoint.report.pages.accuracy import accuracy_page
from boltjoint.report.pages.document import save_page
from boltjoint.study.results import Results

logs.write_to(snakemake.log[0])
params, results = snakemake.params, Results(snakemake.input)
source = results.published()
page = accuracy_page(params.artefacts, results, source, params.cases)
save_page(page, snakemake.output.page, snakemake.output.packed)
