"""Draw figures."""

from boltjoint.report.figures.collection import draw
from boltjoint.report.figures.style import save_figure
from boltjoint.study.results import Results
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
results = Results(snakemake.input)
for artefact in snakemake.params.artefacts:
    save_figure(draw(artefact, results, **snakemake.params.options), artefact.path)
