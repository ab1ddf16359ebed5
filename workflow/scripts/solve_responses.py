"""Solve the frequency responses of a case in a basis, and trace its backbones."""

from boltjoint import dataset
from boltjoint.study.solution import CaseInBasis
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
output, params = snakemake.output, snakemake.params
case = CaseInBasis(**params.case)
solved = case.solve(params.responses, **params.options)
for path, (response, parameters) in zip(output.responses, solved, strict=True):
    dataset.save(response, path, parameters)
for path, (backbone, parameters) in zip(
    output.backbones, case.trace_backbones(params.backbones), strict=True
):
    dataset.save(backbone, path, parameters)
