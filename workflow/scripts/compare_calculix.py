"""Compare modes and contact of an assembly with those that CalculiX finds."""

from pathlib import Path

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.structure.calculix_comparison import Verified
from boltjoint.study.tables import html as tables

logs.write_to(snakemake.log[0])
found, of = snakemake.input, snakemake.params
model = Verified.of_files(of.assembly, Path.cwd(), found.assembly, found.structure)
modes, preload = dataset.load(found.modes), dataset.load(found.preload)
printed = {name: found[f"printed_{name}"] for name in of.decks}
table = model.calculix.compare(model, modes, preload, printed)
tables.write(table, snakemake.output.csv, snakemake.output.html, "Structure beside CalculiX")
