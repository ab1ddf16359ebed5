"""Write the CalculiX input decks of the modes and the preload of an assembly."""

from boltjoint import dataset
from boltjoint.provenance import logs
from boltjoint.structure.makers.half_lap.calculix import write_modes_deck, write_preload_deck

logs.write_to(snakemake.log[0])
assembly, modes, preload = (
    dataset.load(snakemake.input[name]) for name in ("assembly", "modes", "preload")
)
write_modes_deck(assembly, modes.sizes["candidate"], snakemake.output.modes)
write_preload_deck(assembly, preload.attrs["preload_N"], snakemake.output.preload)
