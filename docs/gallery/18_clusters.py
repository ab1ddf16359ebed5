r"""
Clusters of pairs that move alike
=================================

Regions need not be bands. Clusters hold pairs whose motion is similar, wherever they are: with as
many of them the stuck resonance is nearer to that of all pairs.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import apply_preload, connect_nodes, find_modes, partition_regions
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


def stuck_resonance(each) -> float:  # noqa: ANN001
    """Frequency of the first mode with all of the contact sticking [Hz]."""
    return float(each.resonance_range()[0, 1])


# %%
# Error of the stuck resonance by the number of regions:

counts = [2, 4, 8, 16]
error = {
    division: [
        100
        * (
            stuck_resonance(partition_regions(joint, preload, n, division)) / stuck_resonance(joint)
            - 1
        )
        for n in counts
    ]
    for division in ("equal-load", "clusters")
}
clusters = partition_regions(joint, preload, 8, "clusters")
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
x, y = 1e3 * joint.position[:, :2].T
left.scatter(x, y, c=clusters.law.point_of_element, cmap="tab10", s=20)
left.set(xlabel="x (mm)", ylabel="y (mm)", title="Pairs under load, by cluster", aspect="equal")
for division, values in error.items():
    right.loglog(counts, np.abs(values), "o-", label=division)
right.set_xticks(counts, [str(n) for n in counts])
right.minorticks_off()
right.set(xlabel="Regions", ylabel="Error of the stuck resonance (%)")
right.legend()
print({division: [round(each, 3) for each in values] for division, values in error.items()})
