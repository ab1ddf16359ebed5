"""Find a modal basis of an assembly: modes without contact, or vectors that hold the contact."""

from boltjoint import dataset, logs
from boltjoint.structure import export, modes

logs.write_to(snakemake.log[0])
params = snakemake.params
assembly = dataset.load(snakemake.input.assembly)
contact = {}
if params.enrichment is not None:
    contact["preload"] = dataset.load(snakemake.input.preload)
    contact["enrichment"] = modes.Enrichment(**params.enrichment)
found = modes.find_modes(assembly, params.family, **contact)
dataset.save(found, snakemake.output.modes, params)
export.write_modes(assembly, found, snakemake.output.view)
