r"""
Another preload
===============

Two bars with two bolts, from their dimensions. More preload lets less of the contact slip: the
resonance rises and the peak grows. The mesh is coarse and the modes are those without contact, so
that the example takes seconds; studies take a finer mesh and a contact-adapted basis.
"""

from pathlib import Path

import matplotlib.pyplot as plt

from boltjoint import apply_preload, by_force, connect_nodes, find_modes, solve_response
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

# %%
# Only the preload and what follows from it is computed again.

figure, axes = plt.subplots(layout="constrained")
peaks = {}
for newton in (4e3, 8e3, 15e3):
    preload = apply_preload(structure, newton)
    stiffness = 2e13 * preload["area"].to_numpy()  # N/m, of each pair
    joint = connect_nodes(modes, preload, stiffness, 0.3)
    response = solve_response(joint, [10.0], damping=0.001)
    peaks[newton] = response["peak_frequency"].item()
    curve = by_force(response).sel(force=10.0)
    axes.semilogy(curve["frequency"], 1e3 * curve["response_amplitude"], label=f"{newton:g} N")
axes.set(xlabel="Frequency (Hz)", ylabel="Response to 10 N (mm)")
axes.legend(title="Preload of each bolt")

# %%
# Resonance frequencies in Hz by preload in N:

print({newton: round(frequency, 1) for newton, frequency in peaks.items()})
