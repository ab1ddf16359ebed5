r"""
A deck of Abaqus or CalculiX
============================

A deck is read as it is. This one is written by the example: two cantilevered halves of a bar of
bricks that overlap, a bolt whose head and nut are held by couplings, and contact between the
halves. ``boltjoint check`` tells the same of a deck that a study names.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import apply_preload, connect_nodes, find_modes, solve_response
from boltjoint.config.makers import description_of
from boltjoint.structure.makers.registry import make


def block(start: int, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[list[str], list[str]]:
    """Lines of the nodes and the C3D8I elements of a block, numbered from ``start``."""
    number = start + np.arange(x.size * y.size * z.size).reshape(x.size, y.size, z.size)
    node = [
        f"{number[i, j, k]}, {x[i]}, {y[j]}, {z[k]}"
        for i, j, k in np.ndindex(x.size, y.size, z.size)
    ]
    corner = [
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    ]
    element = [
        ", ".join(
            str(each)
            for each in (
                start + at,
                *(number[i + a, j + b, k + c] for a, b, c in corner),
            )
        )
        for at, (i, j, k) in enumerate(np.ndindex(x.size - 1, y.size - 1, z.size - 1))
    ]
    return node, element


# %%
# Two blocks of 200 mm that overlap by 60 mm. Surfaces are named by elements and their faces.

y, z = np.linspace(-10, 10, 5), np.linspace(-8, 0, 3)
lower = block(1, np.linspace(0, 200, 21), y, z)
upper = block(1001, np.linspace(140, 340, 21), y, z + 8)


def elements(lines: list[str], start: int, low: float, high: float, layer: int) -> str:
    """Numbers of the elements of a layer between two places along a block [mm]."""
    columns = range(int(low / 10), int(high / 10))
    return "\n".join(str(start + (i * 4 + j) * 2 + layer) for i in columns for j in range(4))


text = "*HEADING\ntwo blocks\n"
for name, (node, element) in {"LOWER": lower, "UPPER": upper}.items():
    text += f"*NODE, NSET={name}\n" + "\n".join(node) + "\n"
    text += f"*ELEMENT, TYPE=C3D8I, ELSET={name}\n" + "\n".join(element) + "\n"
    text += f"*SOLID SECTION, ELSET={name}, MATERIAL=STEEL\n"
faces = {
    "TOP": (elements(lower[1], 1, 140, 200, 1), "S2"),
    "BOTTOM": (elements(upper[1], 1001, 0, 60, 0), "S1"),
    "HEAD": (elements(upper[1], 1001, 20, 40, 1), "S2"),
    "NUT": (elements(lower[1], 1, 160, 180, 0), "S1"),
}
for name, (numbers, face) in faces.items():
    text += f"*ELSET, ELSET=OF {name}\n{numbers}\n*SURFACE, NAME={name}\nOF {name}, {face}\n"

# %%
# A bolt is two couplings: only their distance along the axis may change, by which it is tightened.

text += """*NODE
5000, 170., 0., 8.
5001, 170., 0., -8.
*COUPLING, CONSTRAINT NAME=head, REF NODE=5000, SURFACE=HEAD
*DISTRIBUTING
*COUPLING, CONSTRAINT NAME=nut, REF NODE=5001, SURFACE=NUT
*DISTRIBUTING
*EQUATION
2
5000, 4, 1., 5001, 4, -1.
2
5000, 5, 1., 5001, 5, -1.
2
5000, 6, 1., 5001, 6, -1.
3
5000, 1, 1., 5001, 1, -1., 5001, 5, -16.
3
5000, 2, 1., 5001, 2, -1., 5001, 4, 16.
*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.3
*DENSITY
7.85E-9
*NSET, NSET=CLAMP
"""
text += "\n".join(str(each) for each in range(1, 16)) + "\n*BOUNDARY\nCLAMP, 1, 3\n"
text += "*STEP\n*STATIC\n*CLOAD\n5000, 3, -8000.\n5001, 3, 8000.\n*END STEP\n"

with TemporaryDirectory() as folder:
    Path(folder, "joint.inp").write_text(text)
    description = {
        "type": "deck",
        "file": "joint.inp",
        "units": {"length": "mm", "mass": "t"},
        "contact": [{"name": "lap", "surfaces": ["TOP", "BOTTOM"], "penalty_N_per_m3": 1e14}],
        "base": "closed",
        "points": [{"name": "tip", "near_mm": [340, 0, 8], "direction": "z"}],
    }
    assembly, structure = make(description_of(description), Path(folder))

# %%
# From here on it is a structure like any other.

preload = apply_preload(structure, 8e3)
stiffness = 1e13 * preload["area"].to_numpy()
joint = connect_nodes(find_modes(structure, "all-8"), preload, stiffness, 0.2)
response = solve_response(joint, [0.2, 5.0], damping=0.001)

place = 1e3 * preload["position"].to_numpy()
figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
pressure = preload["normal_load"] / preload["area"] / 1e6
drawn = axes.scatter(place[:, 0], place[:, 1], c=pressure, s=700, marker="s", cmap="viridis")
axes.set(xlabel="x (mm)", ylabel="y (mm)", title="Contact pressure (MPa)", aspect="equal")
figure.colorbar(drawn)

# %%
# Degrees of freedom, total normal load (N), and resonances in Hz:

print(structure.dofs, round(preload["normal_load"].sum().item(), 3))
print(response["peak_frequency"].round(2).values)
