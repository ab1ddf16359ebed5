"""Time the frequency responses of a case in a basis with forward differences, as the source did."""

from boltjoint import csv_files
from boltjoint.provenance import logs
from boltjoint.study.solution import CaseInBasis

logs.write_to(snakemake.log[0])
params = snakemake.params
times = CaseInBasis(**params.case).time_by_differences(params.responses, **params.options)
for path, table in zip(snakemake.output.timings, times, strict=True):
    csv_files.write(table, path)
