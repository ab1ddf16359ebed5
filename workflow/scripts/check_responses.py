"""Find the residuals in time of the frequency responses of a case in a basis."""

from boltjoint import csv_files, dataset
from boltjoint.provenance import logs
from boltjoint.verification.residual_in_time import check_solutions

logs.write_to(snakemake.log[0])
checked = zip(
    snakemake.params.joints, snakemake.input.responses, snakemake.output.checks, strict=True
)
for joint, response, path in checked:
    table = check_solutions(dataset.load(joint), dataset.load(response))
    csv_files.write(table, path)
