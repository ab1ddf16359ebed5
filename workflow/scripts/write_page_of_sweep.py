"""Write the interactive page of a sweep."""

from pathlib import Path

from boltjoint.config.sweep import Sweep
from boltjoint.provenance import logs
from boltjoint.report.pages.sweep.page import indices_of, sweep_page
from boltjoint.study.stage_inputs import Results

logs.write_to(snakemake.log[0])
name, params, results = snakemake.wildcards.sweep, snakemake.params, Results(snakemake.input)
sweep = Sweep.model_validate(params.sweep)
indices = indices_of(name, sweep, results, params.reported)
content = results.dataset("sweep", sweep=name)
how = {"reported": params.reported, "largest_error": params.largest_error}
page = sweep_page(name, sweep, content, indices, **how)
Path(snakemake.output.page).write_text(page, encoding="utf-8")
