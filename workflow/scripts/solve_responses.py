"""Solve the frequency responses of a case in a basis, and trace its backbones."""

from boltjoint import csv_files, dataset
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.provenance import logs
from boltjoint.study.solution import CaseInBasis

logs.write_to(snakemake.log[0])
output, params = snakemake.output, snakemake.params
case, backbones = CaseInBasis(**params.case), {}
traced = zip(params.backbones, case.trace_backbones(params.backbones), strict=True)
for path, (response, (backbone, parameters, seconds)) in zip(output.backbones, traced, strict=True):
    dataset.save(backbone, path, parameters)
    backbones[response] = backbone, seconds
harmonics = HarmonicConvergence(**params.harmonics) if params.harmonics else None
solved = case.solve(params.responses, backbones, harmonics=harmonics, **params.options)
paths = zip(output.responses, output.timings, strict=True)
for (path, timing), (response, parameters, times) in zip(paths, solved, strict=True):
    dataset.save(response, path, parameters)
    csv_files.write(times, timing)
