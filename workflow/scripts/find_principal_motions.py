"""Find what the motions of an assembly have most in common while its contact sticks and slips."""

from boltjoint import dataset, logs
from boltjoint.structure import enrichment

logs.write_to(snakemake.log[0])
params = snakemake.params
found = enrichment.find_principal_motions(
    dataset.load(snakemake.input.assembly),
    dataset.load(snakemake.input.preload),
    enrichment.Enrichment(**params.enrichment),
    params.most,
)
dataset.save(found, snakemake.output.principal, params)
