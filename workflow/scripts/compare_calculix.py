"""Compare modes and contact of an assembly with those that CalculiX finds."""

from boltjoint import dataset, logs, tables
from boltjoint.structure import calculix

logs.write_to(snakemake.log[0])
found = snakemake.input
assembly = dataset.load(found.assembly)
ours = dataset.load(found.modes), dataset.load(found.preload)
theirs = (
    calculix.read_modes(assembly, found.printed_modes),
    calculix.read_preload(assembly, found.printed_preload),
)
table = calculix.compare(assembly, *ours, *theirs)
tables.write(table, snakemake.output.csv, snakemake.output.html, "Structure beside CalculiX")
