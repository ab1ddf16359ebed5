"""Time and memory of preload and modes of an assembly with and without its symmetry.

    python benchmarks/without_symmetry.py [ASSEMBLY]

Each in a process of its own, by one thread: processor time of both stages, its largest memory, and
how far loads and the first frequencies of the whole are off those of the symmetric half.
"""

import resource
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from boltjoint.config.study import load_study
from boltjoint.structure.makers.registry import make
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

ROOT = Path(__file__).parents[1]
PRELOAD = 10e3  # N
#: bending modes of the half, which a structure without families has among others
BENDING = 2


def solve(name: str, factorisation: str) -> str:
    """Time [s], memory [GB], loads over the preload and frequencies [Hz], by columns."""
    structure = make(load_study(ROOT).assemblies[name], ROOT)[1]
    if factorisation != "half":
        structure = replace(structure, symmetry=None, maker="", factorisation=factorisation)
    start = time.process_time()
    load = apply_preload(structure, PRELOAD)["normal_load"].to_numpy() / PRELOAD
    frequency = find_modes(structure, "free-4")["natural_frequency"].to_numpy()[:BENDING]
    seconds = time.process_time() - start
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return " ".join(f"{each:.17g}" for each in (seconds, memory, *frequency, *load))


def main(name: str = "three_bolt") -> None:
    """Print a line for each way to solve it."""
    half = None
    for way in ("half", "auto", "superlu"):
        command = [sys.executable, __file__, name, way]
        solved = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        seconds, memory, *values = np.array(solved.split(), float)
        line = f"{way:10} {seconds:6.1f} s {memory:5.2f} GB"
        half = (seconds, memory, np.array(values)) if half is None else half
        off = abs(values - half[2]) / np.repeat(
            [1, half[2][BENDING:].max()], [BENDING, len(values) - BENDING]
        )
        off[:BENDING] /= half[2][:BENDING]
        ratios = f"{seconds / half[0]:.2f} of its time, {memory / half[1]:.2f} of its memory"
        print(f"{line}: {ratios}, off by {off.max():.1e}")


if __name__ == "__main__":
    if len(sys.argv) > 2:
        print(solve(*sys.argv[1:3]))
    else:
        main(*sys.argv[1:])
