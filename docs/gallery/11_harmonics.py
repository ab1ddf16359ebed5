r"""
One harmonic and more
=====================

Friction makes odd harmonics. Where much of the contact slips, a model of one harmonic understates
the peak. Peaks are solved with more and more harmonics until two successive ones agree.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import apply_preload, connect_nodes, find_modes
from boltjoint.config.makers import description_of
from boltjoint.dynamics.response.converged_peaks import find_converged_peaks
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
        "ring_cells_across_width": 2,
        "ring_cells_along_bar": 2,
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
forces = [10.0, 50.0]
peaks = find_converged_peaks(joint, forces, damping=0.001)

# %%
# The change of each peak by the number of harmonics:

figure, axes = plt.subplots(layout="constrained")
last = peaks["peak_amplitude_converged"]
for place, force in enumerate(forces):
    on_the_way = peaks["harmonic_peak_amplitude"].isel(force=place) / last[place]
    known = np.isfinite(on_the_way)
    axes.plot(peaks["harmonics"][known], 100 * (on_the_way[known] - 1), "o-", label=f"{force:g} N")
axes.set(xlabel="Highest harmonic", ylabel="Difference from the converged peak (%)", xscale="log")
axes.set_xticks([1, 3, 9, 17, 33], ["1", "3", "9", "17", "33"])
axes.legend()

# %%
# Harmonics that were needed, and the error of one harmonic in percent:

one = peaks["harmonic_peak_amplitude"].sel(harmonics=1)
print(peaks["peak_harmonics"].values.astype(int), (100 * (one / last - 1)).round(1).values)
