"""Make tables."""

from boltjoint.provenance import logs
from boltjoint.report.displays import DISPLAYS
from boltjoint.study.results import Results
from boltjoint.study.tables import files as tables

logs.write_to(snakemake.log[0])
results, params = Results(snakemake.input), snakemake.params
for artefact, options in zip(params.artefacts, params.options, strict=True):
    display = DISPLAYS.of(artefact)
    found = display.make(artefact, results, **options)
    tables.write(found, *artefact.paths[:2], display.heading_of(artefact))
