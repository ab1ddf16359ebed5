"""Write the page of a case."""

from boltjoint import logs
from boltjoint.config import Case, Solver
from boltjoint.pages import case, markup
from boltjoint.published import Published

logs.write_to(snakemake.log[0])
found, params = snakemake.input, snakemake.params
name, configured = snakemake.wildcards.case, Case.model_validate(params.case)
source = Published.beside(found.published[0], configured.published)
solver = Solver.model_validate(params.solver)
files = [*found.shown, *found.joints]
page = case.page(name, configured, solver, files, source, params.cases)
markup.save(page, snakemake.output.page, snakemake.output.packed)
