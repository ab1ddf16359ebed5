"""Tabulate natural frequencies and contact beside the published ones."""

from boltjoint.study.published import Published
from boltjoint.study.results import Results
from boltjoint.study.tables import files as tables
from boltjoint.study.tables.structure import tabulate_contact, tabulate_frequencies
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
results, params = Results(snakemake.input), snakemake.params
source = Published.beside(snakemake.input.published[0])
for table in params.frequencies:
    modes = {a: results.dataset("modes", assembly=a, basis=table.basis) for a in params.assemblies}
    found = tabulate_frequencies(modes, source)
    tables.write(found, *table.paths, "Natural frequencies without contact")
loads = {(a, n): results.dataset("preload", assembly=a, preload_N=n) for a, n in params.preloads}
tables.write(tabulate_contact(loads, source), *params.contact.paths, "Contact under bolt preload")
