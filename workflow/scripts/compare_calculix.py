"""Compare modes and contact of an assembly with those that CalculiX finds."""

from boltjoint import dataset
from boltjoint.structure.calculix.comparison import compare_with_calculix
from boltjoint.structure.calculix.results import read_modes, read_preload
from boltjoint.study.tables import files as tables
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
found = snakemake.input
assembly = dataset.load(found.assembly)
ours = dataset.load(found.modes), dataset.load(found.preload)
theirs = (
    read_modes(assembly, found.printed_modes),
    read_preload(assembly, found.printed_preload),
)
table = compare_with_calculix(assembly, *ours, *theirs)
tables.write(table, snakemake.output.csv, snakemake.output.html, "Structure beside CalculiX")
