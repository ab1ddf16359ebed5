"""Write the page of the assemblies."""

from boltjoint import logs
from boltjoint.config import Assembly
from boltjoint.pages import markup, structure
from boltjoint.published import Published

logs.write_to(snakemake.log[0])
found, params = snakemake.input, snakemake.params
assemblies = {name: Assembly.model_validate(one) for name, one in params.assemblies.items()}
source = Published.beside(found.published[0])
page = structure.page(assemblies, [*found.shown, *found.meshes], source, params.cases)
markup.save(page, snakemake.output.page, snakemake.output.packed)
