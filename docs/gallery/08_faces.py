r"""
Faces that do not match
=======================

Two blocks with different meshes meet. Each contact point is a weighted mean over the common parts
of their faces, so that an even pressure has the right resultant on both sides, whatever the
meshes.
"""

import matplotlib.pyplot as plt
import numpy as np

from boltjoint.structure.elements.assembly import ElementBlock
from boltjoint.structure.elements.kinds import KINDS
from boltjoint.structure.elements.matrices import IsotropicMaterial
from boltjoint.structure.nonmatching_faces.weighted_points import weighted_points


def block(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes [m] and bricks of a block."""
    node = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(node)).reshape(x.size, y.size, z.size)
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
    end = [size - 1 for size in number.shape]
    brick = [number[a : a + end[0], b : b + end[1], c : c + end[2]].ravel() for a, b, c in corner]
    return node, np.column_stack(brick)


lower, of_lower = block(np.linspace(0, 0.06, 7), np.linspace(0, 0.03, 4), np.array([-0.01, 0.0]))
upper, of_upper = block(np.linspace(0.01, 0.07, 6), np.linspace(0, 0.03, 6), np.array([0.0, 0.01]))
node = np.concatenate([lower, upper])
steel = IsotropicMaterial(210e9, 0.3, 7850)
blocks = [
    ElementBlock(KINDS["C3D8I"], of_lower, steel),
    ElementBlock(KINDS["C3D8I"], of_upper + len(lower), steel),
]
face = [
    blocks[0].connectivity[:, KINDS["C3D8I"].face("S2")],
    blocks[1].connectivity[:, KINDS["C3D8I"].face("S1")],
]
points = weighted_points(node, [face[0]], [face[1]], along=np.array([1.0, 0, 0]))

# %%
# Only the common part, 50 by 30 mm, has contact points. An even pressure of 1 MPa on it:

pressure = 1e6
normal = points.contact_points().relative[2::3]
nodal_force = normal.T @ (pressure * points.area)
resultants = [
    nodal_force.reshape(-1, 3)[part].sum(axis=0)
    for part in (slice(len(lower)), slice(len(lower), None))
]

figure, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
for each, colour in zip(face, ("tab:blue", "tab:orange"), strict=True):
    for corners in node[each]:
        axes.fill(*(1e3 * corners[:, :2]).T, fill=False, edgecolor=colour)
axes.scatter(*(1e3 * points.position[:, :2]).T, s=4e5 * points.area, color="0.3", zorder=3)
axes.set(xlabel="x (mm)", ylabel="y (mm)", title="Faces of both sides, and contact points by area")
axes.set_aspect("equal")

# %%
# Area in mm², and resultants along z on both sides in N (pressure times area is 1500 N):

print(round(1e6 * points.area.sum(), 6), [round(float(each[2]), 6) for each in resultants])
