"""Compare modes and contact of assemblies with those that CalculiX finds."""

import pandas as pd

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.structure.makers.half_lap.calculix import read_modes, read_preload
from boltjoint.structure.makers.half_lap.comparison_with_calculix import compare_with_calculix
from boltjoint.study.tables import html as tables

logs.write_to(snakemake.log[0])
found, compared = snakemake.input, {}
for number, name in enumerate(snakemake.params.assemblies):
    kinds = ("assembly", "modes", "preload")
    assembly, modes, preload = (dataset.load(found[kind][number]) for kind in kinds)
    other_modes = read_modes(assembly, found.printed_modes[number])
    other_preload = read_preload(assembly, found.printed_preload[number])
    compared[name] = compare_with_calculix(assembly, modes, preload, other_modes, other_preload)
table = pd.concat(compared, names=["assembly"]).reset_index(level="assembly")
tables.write(table, snakemake.output.csv, snakemake.output.html, "Structure beside CalculiX")
