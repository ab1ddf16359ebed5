"""Write the page of a case."""

from boltjoint.config.case import Case
from boltjoint.config.options import Solver
from boltjoint.report.pages.case.page import case_page
from boltjoint.report.pages.document import save_page
from boltjoint.study.published import Published
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
found, params = snakemake.input, snakemake.params
name, configured = snakemake.wildcards.case, Case.model_validate(params.case)
source = Published.beside(found.published[0], configured.published)
solver = Solver.model_validate(params.solver)
files = [*found.shown, *found.joints]
page = case_page(name, configured, solver, files, source, params.cases)
save_page(page, snakemake.output.page, snakemake.output.packed)
