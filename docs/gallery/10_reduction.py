r"""
Reductions of a joint compared
==============================

A joint with a friction element on every contact pair, and four smaller ones: bands and clusters
that move as one, clusters with few fitted elements, and weighted pairs.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import (
    apply_preload,
    connect_nodes,
    find_modes,
    fit_reduced_joint,
    partition_regions,
    solve_response,
    weigh_pairs,
)
from boltjoint.config.makers import description_of
from boltjoint.structure.makers.registry import make

bars = {
    "bar": {"width_mm": 30, "height_mm": 24, "free_length_mm": [120, 120], "lap_mm": 90},
    "material": {"youngs_modulus_GPa": 70, "poissons_ratio": 0.33, "density_kg_per_m3": 2700},
    "bolts": {
        "positions_from_lap_start_mm": [22.5, 67.5],
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
assembly, structure = make(description_of(bars), Path())
modes = find_modes(structure, "all-12")
preload = apply_preload(structure, 15e3)
joint = connect_nodes(modes, preload, 2e13 * preload["area"].to_numpy(), 0.3)
forces = [1.0, 5.0, 20.0]

# %%
# Each reduction gives a joint, which all solvers take.

clusters = partition_regions(joint, preload, 4, "clusters")
joints = {
    "all pairs": joint,
    "4 bands": partition_regions(joint, preload, 4),
    "4 clusters": clusters,
    "4 clusters, 4 elements": fit_reduced_joint(clusters, 4, method="describing-function")[0],
    "weighted pairs": weigh_pairs(joint, forces, 0.001)[0],
}
peak = {
    name: solve_response(each, forces, damping=0.001)["peak_amplitude"].to_numpy()
    for name, each in joints.items()
}

# %%
# Errors of the peaks in percent. Weighted pairs hold them to the tolerance of 1 %; regions err
# most where slip begins.

error = {name: 100 * (values / peak["all pairs"] - 1) for name, values in peak.items()}
figure, axes = plt.subplots(layout="constrained")
for place, force in enumerate(forces):
    at = np.arange(len(error) - 1) + 0.25 * (place - 1)
    values = [abs(each[place]) for name, each in error.items() if name != "all pairs"]
    axes.bar(at, values, 0.22, label=f"{force:g} N")
axes.set_yscale("log")
axes.set_xticks(np.arange(len(error) - 1), list(error)[1:])
axes.set(ylabel="Error of the peak (%)")
axes.legend()
for name, values in error.items():
    print(f"{name}: {len(joints[name].law.slip_force)} elements, {abs(values).max():.2f} %")
