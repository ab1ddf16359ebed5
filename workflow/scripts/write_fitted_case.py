"""Write a case with the values that were fitted to its measurement."""

from pathlib import Path

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.study.fitted_case import fitted_case

logs.write_to(snakemake.log[0])
calibration = dataset.load(snakemake.input.calibration)
name, content = snakemake.wildcards.case, snakemake.params.case
Path(snakemake.output.case).write_text(fitted_case(name, content, calibration), encoding="utf-8")
