"""Peak memory and time of the stages that need most, for meshes of several sizes.

    python benchmarks/memory.py

meshes the assemblies of the study, coarser, as they are and finer, runs every stage on each in a
process of its own, and prints what it took. The constants of
``study.memory_and_time_of_assemblies`` come from here.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import yaml

from boltjoint import dataset
from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.structure.makers.half_lap.mesh import build_assembly
from boltjoint.structure.modes import find_modes
from boltjoint.structure.patterns import resonances
from boltjoint.structure.preload import apply_preload

ASSEMBLIES = Path(__file__).parents[1] / "config/assemblies"

COULOMB = {"tangential_stiffness_N_per_m": 1e8, "friction_coefficient": 0.1}
#: those of the cases of three_bolt, as far as memory and time are concerned
CONDITIONS = [
    ContactCondition.of({**COULOMB, "law": "constant"}, 2e-3),
    ContactCondition.of({**COULOMB, "law": "variable", "normal_stiffness_N_per_m": 1e8}, 2e-3),
]

#: divisions of the meshes, by assembly; the others are as configured
MESHES = {
    "coarse": (
        "three_bolt",
        {
            "ring_cells_across_width": 6,
            "ring_cells_along_bar": 5,
            "rings_head_to_cell_edge": 3,
            "columns_at_each_lap_end": 3,
            "layers_per_half_height": 2,
            "element_length_free_mm": 12,
        },
    ),
    "medium": (
        "three_bolt",
        {
            "ring_cells_across_width": 8,
            "ring_cells_along_bar": 8,
            "rings_head_to_cell_edge": 4,
            "columns_at_each_lap_end": 4,
            "layers_per_half_height": 3,
            "element_length_free_mm": 8,
        },
    ),
    "three_bolt": ("three_bolt", {}),
    "four_bolt": ("four_bolt", {}),
    "fine": (
        "three_bolt",
        {
            "ring_cells_across_width": 16,
            "ring_cells_along_bar": 13,
            "rings_under_head": 3,
            "rings_head_to_cell_edge": 8,
            "layers_per_half_height": 5,
            "element_length_free_mm": 5,
            "columns_at_each_lap_end": 8,
        },
    ),
}


def configured(name: str) -> LapJoint:
    """The assembly with the divisions of a mesh."""
    assembly, divisions = MESHES[name]
    content = yaml.safe_load((ASSEMBLIES / f"{assembly}.yaml").read_text())
    return LapJoint.model_validate({**content, "mesh": {**content["mesh"], **divisions}})


def stages(name: str, folder: Path) -> dict[str, Callable[[], None]]:
    """What runs on a mesh; later stages read what earlier ones wrote into the folder."""

    def read(what: str) -> object:
        return dataset.load(folder / f"{what}.nc")

    def write(what: str, found: object) -> None:
        dataset.save(found, folder / f"{what}.nc")

    return {
        "nothing": lambda: None,
        "build_assembly": lambda: write("assembly", build_assembly(configured(name))),
        "apply_preload": lambda: write("preload", apply_preload(read("assembly"), 1e4)),
        "find_modes free-4": lambda: find_modes(read("assembly"), "free-4"),
        "find_modes free-40": lambda: find_modes(read("assembly"), "free-40"),
        "find_pod_modes": lambda: write(
            "pod_modes",
            find_pod_modes(read("assembly"), read("preload"), CONDITIONS, ContactAdaptedBasis()),
        ),
        "find_modes enriched-80": lambda: find_modes(
            read("assembly"), "enriched-80", read("pod_modes")
        ),
        "find_patterns": lambda: resonances(read("assembly"), read("preload"), 1e8),
    }


def run(name: str, stage: str, folder: Path) -> None:
    """Run one stage and print the peak of memory and the time of this process."""
    began = time.process_time()
    stages(name, folder)[stage]()
    seconds = time.process_time() - began
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
    print(f"{name:12} {stage:24} {peak:7.3f} GiB {seconds:8.1f} s", flush=True)


def main() -> None:
    """Every stage of every mesh, each in a process of its own."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="*", default=list(MESHES), help="default: all")
    parser.add_argument("--stage", help="run this stage alone, in this process")
    parser.add_argument("--folder", type=Path, help="where --stage reads and writes")
    options = parser.parse_args()
    if options.stage:
        run(options.meshes[0], options.stage, options.folder)
        return
    for name in options.meshes:
        with tempfile.TemporaryDirectory() as folder:
            for stage in stages(name, Path(folder)):
                command = [sys.executable, __file__, name, "--stage", stage, "--folder", folder]
                subprocess.run(command, check=True)


if __name__ == "__main__":
    main()
