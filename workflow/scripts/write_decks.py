"""Write what CalculiX is asked: the modes of an assembly, and its contact when tightened."""

from boltjoint import dataset, logs
from boltjoint.structure import calculix

logs.write_to(snakemake.log[0])
assembly, modes, preload = (
    dataset.load(snakemake.input[name]) for name in ("assembly", "modes", "preload")
)
calculix.write_modes_deck(assembly, modes.sizes["candidate"], snakemake.output.modes)
calculix.write_preload_deck(assembly, preload.attrs["preload_N"], snakemake.output.preload)
