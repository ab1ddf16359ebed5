"""Write the overview page."""

from boltjoint.config.study import Study
from boltjoint.provenance import logs
from boltjoint.report.pages.document import save_page
from boltjoint.report.pages.overview import overview_page
from boltjoint.reproduction.pages import PagesBesideThesis
from boltjoint.study.stage_inputs import Results

logs.write_to(snakemake.log[0])
params, results = snakemake.params, Results(snakemake.input)
study, source = Study.model_validate(params.study), PagesBesideThesis.among(snakemake.input)
page = overview_page(study, params.artefacts, params.all_artefacts, results, source)
save_page(page, snakemake.output.page, snakemake.output.packed)
