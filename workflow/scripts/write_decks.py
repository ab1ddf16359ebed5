"""Write the CalculiX input decks of the modes and the preload of an assembly."""

from pathlib import Path

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.structure.calculix_comparison import Verified

logs.write_to(snakemake.log[0])
found = snakemake.input
model = Verified.of_files(snakemake.params.assembly, Path.cwd(), found.assembly, found.structure)
modes, preload = dataset.load(found.modes), dataset.load(found.preload)
model.calculix.write_decks(model, modes, preload.attrs["preload_N"], dict(snakemake.output.items()))
