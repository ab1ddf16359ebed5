"""Write the page of a case."""

from boltjoint import logs
from boltjoint.config import Case
from boltjoint.pages import case, markup
from boltjoint.published import Published

logs.write_to(snakemake.log[0])
found, params = snakemake.input, snakemake.params
name, configured = snakemake.wildcards.case, Case.model_validate(params.case)
source = Published.beside(found.published[0], configured.published)
page = case.page(name, configured, [*found.shown, *found.joints], source, params.cases)
markup.save(page, snakemake.output.page, snakemake.output.packed)
