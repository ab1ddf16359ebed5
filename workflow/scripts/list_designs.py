"""List the designs of a sweep: the values of the keys that vary."""

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.study.designs import list_designs

logs.write_to(snakemake.log[0])
params = snakemake.params
how = params.vary, params.design, params.case, params.variants, params.quantities
designs = list_designs(*how, snakemake.input.table or None)
dataset.save(designs, snakemake.output.designs, params)
