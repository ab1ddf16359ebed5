"""Write the overview page."""

from boltjoint.config.study import Study
from boltjoint.report.pages.document import save_page
from boltjoint.report.pages.overview import overview_page
from boltjoint.study.published import Published
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
found, params = snakemake.input, snakemake.params
files = [*found.shown, *found.joints, found.environment]
source = Published.beside(found.published[0])
page = overview_page(Study.model_validate(params.study), files, params.shown, source)
save_page(page, snakemake.output.page, snakemake.output.packed)
