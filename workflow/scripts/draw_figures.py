"""Draw figures."""

from boltjoint.provenance import logs
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.figures.style import save_figure
from boltjoint.study.results import Results

logs.write_to(snakemake.log[0])
results, params = Results(snakemake.input), snakemake.params
for artefact, options in zip(params.artefacts, params.options, strict=True):
    save_figure(DISPLAYS.of(artefact).make(artefact, results, **options), artefact.path)
