"""How often a loosened bolt is found by backbones of three modes.

    python benchmarks/loosened_bolt.py --count 100 --seed 1

draws preloads of a half lap with four bolts: one bolt has 2 to 70 % of the full preload, all
others that with a scatter of 5 %. Its contact is solved anew with these, and its backbones have 1 %
of noise in the damping and 0.1 % in the frequency. The preload of every bolt is fitted to them.
"""

import argparse
import logging
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/calibration"))
from calibrated_joint import backbones_of

from boltjoint import (
    BoltPreloads,
    apply_preload,
    connect_nodes,
    find_modes,
    fit_preloads,
    loosest_bolt,
)
from boltjoint.config.makers import description_of
from boltjoint.damping import LossFactor
from boltjoint.structure.makers.registry import make

PRELOAD, DAMPING = 15e3, LossFactor(0.001)
#: relative standard deviation of the damping; that of the frequency is a tenth of it
NOISE = 0.01
#: amplitudes of each mode at the tip [m], from first slip to a third of the whole shift
AMPLITUDES = {
    1: np.geomspace(1.7e-5, 1e-3, 12),
    2: np.geomspace(2.8e-6, 3.3e-4, 12),
    3: np.geomspace(9.3e-7, 9.6e-5, 12),
}
HALF_LAP = {
    "bar": {"width_mm": 30, "height_mm": 24, "free_length_mm": [120, 120], "lap_mm": 180},
    "material": {"youngs_modulus_GPa": 70, "poissons_ratio": 0.33, "density_kg_per_m3": 2700},
    "bolts": {
        "positions_from_lap_start_mm": [22.5, 67.5, 112.5, 157.5],
        "shank_diameter_mm": 10,
        "hole_diameter_mm": 11,
        "head_diameter_mm": 16,
        "head_height_mm": 6.4,
        "nut_height_mm": 8.4,
    },
    "mesh": {
        "ring_cells_across_width": 4,
        "ring_cells_along_bar": 4,
        "rings_under_head": 1,
        "rings_head_to_cell_edge": 2,
        "bolt_cell_length_mm": 32,
        "columns_between_bolt_cells": 1,
        "columns_at_each_lap_end": 1,
        "layers_per_half_height": 2,
        "element_length_free_mm": 20,
        "rings_in_shank": 1,
        "layers_in_head": 1,
    },
}


def preloads(seed: int, index: int) -> NDArray[np.float64]:
    """Preload of each bolt over the full one, of which one is loose."""
    random = np.random.default_rng([seed, index])
    ratios = np.clip(random.normal(1.0, 0.05, 4), 0.8, 1.2)
    ratios[random.integers(4)] = random.uniform(0.02, 0.7)
    return ratios


def main() -> None:
    """Fit, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="index of the first joint")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    # a bolt that is tighter than the others is strained beyond yield
    logging.disable(logging.WARNING)
    _, structure = make(description_of(HALF_LAP), Path())
    modes = find_modes(structure, "free-16")
    stiffness = 2e13 * structure.contact.area
    connect = partial(
        connect_nodes, modes, tangential_stiffness=stiffness, friction_coefficient=0.3
    )
    model = BoltPreloads(structure, PRELOAD, connect, DAMPING)
    found_right, within, seconds = 0, 0, []
    for index in range(args.first, args.first + args.count):
        ratios = preloads(args.seed, index)
        joint = connect(apply_preload(structure, PRELOAD * ratios))
        curves = backbones_of(joint, DAMPING, AMPLITUDES, NOISE, [args.seed, index, 1])
        begun = time.process_time()
        found = fit_preloads(model, curves)
        seconds.append(time.process_time() - begun)
        # an answer that is refused counts as wrong
        probability = {} if found.refusals else loosest_bolt(found)
        loosest = int(np.argmax(list(probability.values()))) if probability else -1
        is_right = loosest == np.argmin(ratios)
        found_right += is_right
        off = abs(found.scaled - ratios) / found.standard_error
        within += np.count_nonzero(off <= 1.96)
        print(
            f"{index}: {np.round(ratios, 3)}, found {np.round(found.scaled, 3)} "
            f"+- {np.round(found.standard_error, 3)}, bolt {loosest} with "
            f"{max(probability.values(), default=0.0):.3f}{'' if is_right else ' WRONG'}, "
            f"sum of squares {2 * found.costs.min():.0f} of {2 * 3 * 12} values",
            flush=True,
        )
    print(
        f"the loose bolt is the most probable one {found_right} of {args.count} times; "
        f"{within} of {4 * args.count} preloads lie in their 95 % intervals; "
        f"{np.median(seconds):.0f} s of processor time a fit"
    )


if __name__ == "__main__":
    main()
