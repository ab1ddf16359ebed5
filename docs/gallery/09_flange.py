r"""
A flange
========

Two rings of steel with eight bolts, meshed with bricks. The lower ring stands on its outer edge.
The bolts sit near the inner edge, where the contact pressure is largest. Around a loose bolt there
is almost none.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from scipy import sparse

from boltjoint import Structure, apply_preload, connect_nodes, find_modes, solve_response
from boltjoint.structure.elements.assembly import ElementBlock, assemble
from boltjoint.structure.elements.kinds import KINDS
from boltjoint.structure.elements.matrices import IsotropicMaterial
from boltjoint.structure.nonmatching_faces.weighted_points import weighted_points

BOLTS, SECTORS = 8, 32
radius = np.array([0.04, 0.05, 0.06, 0.07])  # m


def ring(height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes [m] and bricks of a closed ring."""
    angle = 2 * np.pi * np.arange(SECTORS) / SECTORS
    r, a, z = np.meshgrid(radius, angle, height, indexing="ij")
    node = np.stack([r * np.cos(a), r * np.sin(a), z], axis=-1).reshape(-1, 3)
    number = np.arange(len(node)).reshape(r.shape)
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
    turned = np.concatenate([number, number[:, :1]], axis=1)
    end = np.array(turned.shape) - 1
    brick = [turned[i : i + end[0], j : j + end[1], k : k + end[2]].ravel() for i, j, k in corner]
    return node, np.column_stack(brick)


lower, brick = ring(np.array([-0.02, -0.01, 0.0]))
upper = lower * [1, 1, -1]
# the mirror image turns its bricks inside out
mirrored = brick[:, [4, 5, 6, 7, 0, 1, 2, 3]]
node = np.concatenate([lower, upper])
steel = IsotropicMaterial(210e9, 0.3, 7850)
kind = KINDS["C3D8I"]
blocks = [ElementBlock(kind, brick, steel), ElementBlock(kind, mirrored + len(lower), steel)]
K, M = assemble(node, blocks)

# %%
# Faces of the contact are those at z = 0.

top, bottom = (
    block.connectivity[:, kind.face(name)] for block, name in zip(blocks, ("S2", "S1"), strict=True)
)
top, bottom = (each[(abs(node[each][..., 2]) < 1e-9).all(axis=1)] for each in (top, bottom))
points = weighted_points(node, [top], [bottom], along=np.array([1.0, 0, 0]))

# %%
# The outer lower edge is held: its displacements are left out. Shanks are springs along x, y and
# their own axis; the axial one has its shortening as a further degree of freedom, by which it is
# tightened.

held = (abs(node[:, 2] + 0.02) < 1e-9) & (np.hypot(*node[:, :2].T) > 0.069)
kept = np.flatnonzero(~np.repeat(held, 3))
dofs = kept.size
free = sparse.csr_array((np.ones(dofs), (kept, np.arange(dofs))), (3 * len(node), dofs + BOLTS))
K, M = (free.T @ each @ free for each in (K, M))
shortening = {}
for bolt in range(BOLTS):
    angle = 2 * np.pi * bolt / BOLTS
    ends = 0.05 * np.cos(angle), 0.05 * np.sin(angle)
    nut, head = (int(np.argmin(np.linalg.norm(node - [*ends, z], axis=1))) for z in (-0.02, 0.02))
    for axis, stiffness in enumerate((2e7, 2e7, 2e8)):
        row = (free[[3 * nut + axis]] - free[[3 * head + axis]]).tolil()
        if axis == 2:
            row[0, dofs + bolt] = -1
        row = row.tocsc()
        K = K + stiffness * row.T @ row
    shortening[f"bolt {bolt + 1}"] = dofs + bolt
contact = points.contact_points(free, penalty=1e15)

# a torque of 1 N m on the rim as four forces, and the motion along them
rim = np.zeros((1, 3 * len(node)))
for angle in np.pi / 2 * np.arange(4):
    direction = np.array([-np.sin(angle), np.cos(angle), 0.0])
    at = 0.07 * np.array([np.cos(angle), np.sin(angle), 0.0]) + [0, 0, 0.02]
    nearest = int(np.argmin(np.linalg.norm(node - at, axis=1)))
    rim[0, 3 * nearest : 3 * nearest + 3] = direction / (4 * 0.07)
place = (rim @ free).ravel()
structure = Structure.from_matrices(
    K, M, contact, bolts=shortening, inputs={"rim": place}, outputs={"rim": place}
)

# %%
# Seven bolts are tight, one is not.

tight = apply_preload(structure, 5e3)
loose = apply_preload(structure, [*[5e3] * (BOLTS - 1), 0.0])
figure, axes = plt.subplots(1, 2, figsize=(8, 3.6), layout="constrained")
for each, axis, title in zip((tight, loose), axes, ("all tight", "one loose"), strict=True):
    pressure = each["normal_load"] / each["area"] / 1e6
    x, y = 1e3 * each["position"].to_numpy()[:, :2].T
    drawn = axis.scatter(x, y, c=pressure, s=60, cmap="viridis", vmin=0)
    axis.set(title=title, aspect="equal", xlabel="x (mm)")
figure.colorbar(drawn, ax=axes, label="Contact pressure (MPa)")

# %%
# Under preload the rings stay closed: modes have normal springs where the contact carries load.
# ``free-2`` are the first two modes that the torque excites. Total normal load in N, and resonances
# in Hz at a small and a large torque:

for name, each in {"all tight": tight, "one loose": loose}.items():
    springs = np.where(each["normal_load"] > 0, 1e14 * each["area"], 0.0)
    modes = find_modes(replace(structure, base_springs=springs), "free-2")
    joint = connect_nodes(modes, each, 1e11 * each["area"].to_numpy(), 0.2)
    response = solve_response(joint, [10.0, 300.0], damping=0.01)
    total = each["normal_load"].sum().item()
    print(f"{name}: {total:.1f} N, {response['peak_frequency'].round(1).values} Hz")
