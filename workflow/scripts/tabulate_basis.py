"""Tabulate the results of a case in a basis."""

from boltjoint.study.published import Published
from boltjoint.study.results import Results
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.of_basis import BasisTables
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
published = Published.beside(snakemake.input.published[0], params.published)
of_basis = BasisTables(Results(snakemake.input), published=published, **params.of_basis)
for artefact in params.artefacts:
    table, title = of_basis.tabulate(artefact)
    tables.write(table, *artefact.paths, title)
