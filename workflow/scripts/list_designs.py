"""List the designs of a sweep: the values of the keys that vary."""

from boltjoint import dataset
from boltjoint.study.designs import list_designs
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
params = snakemake.params
table = snakemake.input.table or None
designs = list_designs(params.vary, params.design, params.case, table)
dataset.save(designs, snakemake.output.designs, params)
