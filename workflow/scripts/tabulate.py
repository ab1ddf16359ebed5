"""Make tables."""

from boltjoint.provenance import logs
from boltjoint.report.displays import DISPLAYS
from boltjoint.reproduction.comparison import ThesisComparison
from boltjoint.study.stage_inputs import Results
from boltjoint.study.tables import html as tables

logs.write_to(snakemake.log[0])
results, params = Results(snakemake.input), snakemake.params
tabulated = zip(params.artefacts, params.options, params.counterparts, strict=True)
for artefact, options, counterpart in tabulated:
    display = DISPLAYS.of(artefact)
    source = ThesisComparison.among(snakemake.input, counterpart)
    table = display.content(artefact, results, options, source)
    tables.write(table, *artefact.paths[:2], display.heading_of(artefact))
