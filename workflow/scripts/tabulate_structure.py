"""Tabulate natural frequencies and contact beside the published ones."""

from boltjoint.study.published import Published
from boltjoint.study.results import Results
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.structure import tabulate_structure
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
results, params = Results(snakemake.input), snakemake.params
source = Published.beside(snakemake.input.published[0])
made = tabulate_structure(params.artefacts, results, params.assemblies, params.preloads, source)
for artefact, (table, title) in zip(params.artefacts, made, strict=True):
    tables.write(table, *artefact.paths, title)
