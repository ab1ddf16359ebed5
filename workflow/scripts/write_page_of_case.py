"""Write the page of a case."""

from boltjoint.config.case import Case
from boltjoint.config.numerical_options import Solver
from boltjoint.provenance import logs
from boltjoint.report.pages.case.page import case_page
from boltjoint.report.pages.document import save_page
from boltjoint.reproduction.pages import PagesBesideThesis
from boltjoint.study.stage_inputs import Results

logs.write_to(snakemake.log[0])
params, results = snakemake.params, Results(snakemake.input)
case, solver = Case.model_validate(params.case), Solver.model_validate(params.solver)
source = PagesBesideThesis.among(snakemake.input, case.published)
content = (params.artefacts, results, source)
page = case_page(snakemake.wildcards.case, case, solver, *content, params.cases)
save_page(page, snakemake.output.page, snakemake.output.packed)
