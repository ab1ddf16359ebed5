"""Write the page of the assemblies."""

from boltjoint.config.assembly import Assembly
from boltjoint.report.pages.document import save_page
from boltjoint.report.pages.structure import structure_page
from boltjoint.study.published import Published
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
found, params = snakemake.input, snakemake.params
assemblies = {name: Assembly.model_validate(one) for name, one in params.assemblies.items()}
source = Published.beside(found.published[0])
page = structure_page(assemblies, [*found.shown, *found.meshes], source, params.cases)
save_page(page, snakemake.output.page, snakemake.output.packed)
