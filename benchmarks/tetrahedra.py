"""A half lap in 10-node tetrahedra beside bricks with the same nodes, both read from decks.

    python benchmarks/tetrahedra.py [HALVINGS]

The bricks of a coarse lap of two bolts are cut into eight as often as told, then each into six
tetrahedra or once more into eight. Printed are time and memory of each stage (a process for each
mesh), the natural frequencies without contact, and frequency and damping of the first mode over
the amplitude in a contact-adapted basis: no halving (43,000 degrees of freedom) takes two minutes,
one (305,000) half an hour and 10 GB.
"""

import resource
import sys
import time
from pathlib import Path
from subprocess import run
from tempfile import TemporaryDirectory

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/structure/half_lap"))
import examples
from deck_of_assembly import deck_of_finer

from boltjoint.config.deck import Deck
from boltjoint.dynamics.backbone.backbone_at import backbone_at
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.structure.makers.deck.structure import model_of_deck
from boltjoint.structure.model import Structure
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

PRELOAD, LOSS_FACTOR = 8e3, 2e-3  # N
CONTACT = {
    "law": "constant",
    "tangential_stiffness_N_per_m3": 1e12,
    "friction_coefficient": 0.1,
}
AMPLITUDES = [1e-6, 3e-5, 1e-4, 3e-4, 1e-3]  # m
BASIS, FREE = "enriched-24", "free-4"


def structure_of(halvings: int, *, tetrahedra: bool) -> Structure:
    """The lap with its bricks cut into eight so often, or into tetrahedra after that."""
    assembly = examples.build_assembly(examples.coarse_assembly())
    end = 1e3 * assembly["coordinate"].to_numpy()[assembly["response_node"].item()]
    text = deck_of_finer(assembly, PRELOAD, halvings=halvings, tetrahedra=tetrahedra)
    with TemporaryDirectory() as folder:
        (Path(folder) / "lap.inp").write_text(text)
        description = Deck.model_validate(
            {
                "type": "deck",
                "file": "lap.inp",
                "units": {"length": "mm", "mass": "t"},
                "elements": [] if tetrahedra else [{"kind": "C3D8R", "read_as": "C3D8I"}],
                "contact": [{"name": "lap", "surfaces": ["lap_a", "lap_b"]}],
                "points": [{"name": "tip", "near_mm": end.tolist(), "direction": "z"}],
            }
        ).in_folder(Path(folder))
        return model_of_deck(description, description.folder).structure


class Stages:
    """Processor time of each stage, and the memory up to its end."""

    def __init__(self) -> None:
        self._start = time.process_time()

    def end(self, stage: str) -> None:
        """Print what a stage took."""
        now = time.process_time()
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        print(f"  {stage}: {now - self._start:.0f} s, {memory:.2f} GiB", flush=True)
        self._start = now


def solve(halvings: int, *, tetrahedra: bool) -> None:
    """Print the stages and results of one mesh."""
    stages = Stages()
    structure = structure_of(halvings, tetrahedra=tetrahedra)
    count = f"{structure.dofs} degrees of freedom, {len(structure.contact)} contact points"
    print(f"{'tetrahedra' if tetrahedra else 'bricks'}: {count}")
    stages.end("structure")
    preload = apply_preload(structure, PRELOAD)
    stages.end("preload")
    free = find_modes(structure, FREE)
    stages.end("modes without contact")
    pod = find_pod_modes(structure, preload, [ContactCondition.of(CONTACT, LOSS_FACTOR)])
    modes = find_modes(structure, BASIS, pod)
    stages.end(f"basis {BASIS}")
    joint = ContactCondition.of(CONTACT, LOSS_FACTOR).connect(preload, modes)
    frequency, damping = backbone_at(joint, AMPLITUDES, damping=LOSS_FACTOR)
    stages.end("backbone")
    load = float(preload["normal_load"].sum())
    print(f"  normal load over tension, less one: {load / (2 * PRELOAD) - 1:.1e}")
    with np.printoptions(precision=5, linewidth=120):
        print(f"  without contact (Hz): {free['natural_frequency'].to_numpy()}")
        print(f"  amplitude (mm): {1e3 * np.array(AMPLITUDES)}")
        print(f"  frequency (Hz): {frequency}")
        print(f"  damping (%): {100 * damping}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) == 3:
        solve(int(sys.argv[1]), tetrahedra=sys.argv[2] == "tetrahedra")
    else:
        halvings = int(sys.argv[1]) if len(sys.argv) == 2 else 0
        run([sys.executable, __file__, str(halvings), "tetrahedra"], check=True)
        run([sys.executable, __file__, str(halvings + 1), "bricks"], check=True)
