"""Write the page of the accuracy of all models."""

from boltjoint.config.case import Case
from boltjoint.provenance import logs
from boltjoint.report.pages.accuracy import accuracy_page
from boltjoint.report.pages.document import save_page
from boltjoint.reproduction.pages import PagesBesideThesis
from boltjoint.study.stage_inputs import Results

logs.write_to(snakemake.log[0])
params, results = snakemake.params, Results(snakemake.input)
source = PagesBesideThesis.among(snakemake.input)
cases = {name: Case.model_validate(content) for name, content in params.cases.items()}
page = accuracy_page(params.artefacts, results, source, cases)
save_page(page, snakemake.output.page, snakemake.output.packed)
