r"""
One loosened bolt
=================

The preload of each bolt may differ. Here the second one loses 90 % of its own. At small forces
little changes in this joint, as what still carries load sticks; at large ones half of the joint
slips, and the resonance falls.
"""

from pathlib import Path

import matplotlib.pyplot as plt

from boltjoint import (
    ContactCondition,
    apply_preload,
    connect_nodes,
    find_backbone,
    find_modes,
    find_pod_modes,
    frequency_window,
    solve_response,
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
contact = {
    "law": "constant",
    "tangential_stiffness_N_per_m3": 2e13,
    "friction_coefficient": 0.3,
}

# %%
# Frequency and damping over amplitude, and peaks to two forces, of both joints, each in a basis
# that is made for its contact. The mesh is coarse, as befits an example:

figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
for name, newton in {"both tight": [15e3, 15e3], "one loose": [15e3, 1.5e3]}.items():
    preload = apply_preload(structure, newton)
    pod_modes = find_pod_modes(structure, preload, [ContactCondition.of(contact, 0.001)])
    modes = find_modes(structure, "enriched-24", pod_modes)
    joint = connect_nodes(modes, preload, 2e13 * preload["area"].to_numpy(), 0.3)
    window = frequency_window(joint)
    backbone = find_backbone(joint, [0.1, 50.0], damping=0.001, window=window)
    amplitude = 1e3 * backbone["response_amplitude"]
    left.semilogx(amplitude, backbone["natural_frequency"], label=name)
    right.semilogx(amplitude, 100 * backbone["damping_ratio"])
    peaks = solve_response(joint, [1.0, 20.0], damping=0.001)["peak_frequency"]
    print(f"{name}: {peaks[0].item():.1f} Hz at 1 N, {peaks[1].item():.1f} Hz at 20 N")
left.set(xlabel="Amplitude (mm)", ylabel="Natural frequency (Hz)")
right.set(xlabel="Amplitude (mm)", ylabel="Damping ratio (%)")
left.legend()
