"""List the designs of a sweep: the values of the keys that vary."""

from boltjoint import dataset
from boltjoint.study.designs import list_designs
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
how = params.vary, params.design, params.case, params.variants, params.quantities
designs = list_designs(*how, snakemake.input.table or None)
dataset.save(designs, snakemake.output.designs, params)
