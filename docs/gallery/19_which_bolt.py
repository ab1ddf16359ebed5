r"""
Which bolt is loose?
====================

The preload of a bolt changes the frequency and the damping of each mode by its own amount, so that
backbones of two modes tell two bolts apart. Here the second bolt has 40 % of its preload. Its
backbones, with 1 % of noise in the damping and 0.1 % in the frequency, stand for a measurement.
"""

from functools import partial
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import (
    BoltPreloads,
    MeasuredBackbone,
    apply_preload,
    backbone_at,
    connect_nodes,
    find_modes,
    fit_preloads,
    loosest_bolt,
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
modes = find_modes(structure, "free-8")
stiffness = 2e13 * structure.contact.area
connect = partial(connect_nodes, modes, tangential_stiffness=stiffness, friction_coefficient=0.3)

# %%
# What a test would measure, from a joint whose contact is solved with these preloads:

truth = np.array([1.0, 0.4])
joint = connect(apply_preload(structure, 12e3 * truth))
random, measured = np.random.default_rng(1), []
for resonance, amplitudes in {1: (1e-5, 5e-4), 2: (1e-6, 5e-5)}.items():
    amplitude = np.geomspace(*amplitudes, 10)
    exact = np.array(backbone_at(joint, amplitude, damping=0.001, resonance=resonance))
    scatter = 1 + np.array([[1e-3], [1e-2]]) * random.standard_normal((2, amplitude.size))
    frequency, damping = exact * scatter
    measured.append(
        MeasuredBackbone(
            amplitude,
            frequency,
            1e-3 * frequency,
            damping,
            1e-2 * damping,
            resonance=resonance,
            name=f"mode {resonance}",
        )
    )

# %%
# The preload of each bolt is fitted to them, over that of a tight one:

model = BoltPreloads(structure, 12e3, connect, 0.001)
found = fit_preloads(model, measured)
print(found.summary())
probability = loosest_bolt(found)
print(", ".join(f"{name} is the loosest: {share:.3f}" for name, share in probability.items()))

figure, axes = plt.subplots(figsize=(5, 3.2), layout="constrained")
bolts = np.arange(1, 3)
axes.bar(bolts, truth, width=0.5, color="0.85", label="True preload")
axes.errorbar(bolts, found.scaled, 2 * found.standard_error, fmt="o", capsize=6, label="Fitted")
axes.set(xlabel="Bolt", ylabel="Preload over the full one", xticks=bolts, ylim=(0, 1.3))
axes.legend(loc="upper right")
