"""Find the resonances of the full model while parts of the contact stick."""

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.structure import patterns, structure_file

logs.write_to(snakemake.log[0])
assembly, preload = (dataset.load(snakemake.input[name]) for name in ("assembly", "preload"))
structure = structure_file.load_structure(snakemake.input.structure)
radii = patterns.bolt_radii(assembly) or None
parts = patterns.stuck_patterns(structure, preload, radii)
found = patterns.resonances(structure, preload, patterns=parts, **snakemake.params.options)
dataset.save(found, snakemake.output.patterns, snakemake.params)
