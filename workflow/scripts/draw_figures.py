"""Draw figures."""

from boltjoint.provenance import logs
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.figures.style import save_figure
from boltjoint.reproduction.comparison import ThesisComparison
from boltjoint.study.stage_inputs import Results

logs.write_to(snakemake.log[0])
results, params = Results(snakemake.input), snakemake.params
drawn = zip(params.artefacts, params.options, params.counterparts, strict=True)
for artefact, options, counterpart in drawn:
    source = ThesisComparison.among(snakemake.input, counterpart)
    figure = DISPLAYS.of(artefact).content(artefact, results, options, source)
    save_figure(figure, artefact.path)
