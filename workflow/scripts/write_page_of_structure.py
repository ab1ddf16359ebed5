"""Write the page of the assemblies."""

from boltjoint.config.makers import description_of
from boltjoint.provenance import logs
from boltjoint.report.pages.document import save_page
from boltjoint.report.pages.structure import structure_page
from boltjoint.reproduction.pages import PagesBesideThesis
from boltjoint.study.stage_inputs import Results

logs.write_to(snakemake.log[0])
params, results = snakemake.params, Results(snakemake.input)
assemblies = {name: description_of(content) for name, content in params.assemblies.items()}
source = PagesBesideThesis.among(snakemake.input)
page = structure_page(assemblies, params.artefacts, results, source, params.cases)
save_page(page, snakemake.output.page, snakemake.output.packed)
