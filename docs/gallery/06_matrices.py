r"""
A structure from matrices
=========================

Stiffness and mass matrices of another program, and the rows of its contact, make a structure. Here
the other program is a dozen lines: two cantilevers in the plane, one upon the other, whose ends
overlap. Two bolts press the overlap together.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy import sparse

from boltjoint import (
    ContactPoints,
    Structure,
    apply_preload,
    by_force,
    connect_nodes,
    find_modes,
    solve_response,
)

E, RHO, WIDTH, HEIGHT = 210e9, 7800.0, 0.03, 0.006  # Pa, kg/m3, m, m
LENGTH, CELLS = 0.01, 30  # of an element [m], elements of each bar


def bar() -> tuple[np.ndarray, np.ndarray]:
    """K and M of a bar in the plane: displacement u, w and rotation of each node."""
    area, inertia = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12
    h, dofs = LENGTH, 3 * (CELLS + 1)
    bending = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h**2, -6 * h, 2 * h**2],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h**2, -6 * h, 4 * h**2],
        ]
    )
    moving = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h**2, 13 * h, -3 * h**2],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
        ]
    )
    K, M = np.zeros((dofs, dofs)), np.zeros((dofs, dofs))
    for cell in range(CELLS):
        along = 3 * cell + np.array([0, 3])
        across = 3 * cell + np.array([1, 2, 4, 5])
        K[np.ix_(along, along)] += E * area / h * np.array([[1, -1], [-1, 1]])
        M[np.ix_(along, along)] += RHO * area * h / 6 * np.array([[2, 1], [1, 2]])
        K[np.ix_(across, across)] += E * inertia / h**3 * bending
        M[np.ix_(across, across)] += RHO * area * h / 420 * moving
    return K, M


# %%
# The lower bar is clamped at its left end. The first ten nodes of the upper bar lie on the last
# ten of the lower one. A point of a surface moves along the bar with the rotation of its node.

K, M = (sparse.block_diag([part[3:, 3:], part], format="csc") for part in bar())
of_lower, of_upper = 3 * (np.arange(21, 31) - 1), 3 * (CELLS + np.arange(10))
pairs, dofs = 10, K.shape[0]
relative = np.zeros((3 * pairs, dofs))
for pair, (a, b) in enumerate(zip(of_lower, of_upper, strict=True)):
    # side A, the lower bar, minus side B: along the bar, across it (none in the plane), normal
    relative[3 * pair, [a, a + 2]] += [1, HEIGHT / 2]
    relative[3 * pair, [b, b + 2]] -= [1, -HEIGHT / 2]
    relative[3 * pair + 2, a + 1] += 1
    relative[3 * pair + 2, b + 1] -= 1
# %%
# A shank is a spring along the bar, and one along its own axis between the lower bar, the upper
# one and its shortening. The shortening is a further degree of freedom: a bolt is tightened by a
# force on it, and then it is held.

shank = (2, 7)  # pairs
K, M = (sparse.block_diag([each, sparse.csc_array((2, 2))], format="csc") for each in (K, M))
relative = np.hstack([relative, np.zeros((3 * pairs, 2))])
for n, pair in enumerate(shank):
    axial = relative[3 * pair + 2].copy()
    axial[dofs + n] = -1
    for stiffness, row in ((2e5, relative[3 * pair]), (3e8, axial)):
        row = sparse.csc_array(row[None])
        K = K + stiffness * row.T @ row
x = 0.21 + LENGTH * np.arange(pairs)
contact = ContactPoints(
    sparse.csr_array(relative),
    position=np.column_stack([x, 0 * x, 0 * x]),
    frame=np.tile(np.eye(3), (pairs, 1, 1)),
    area=np.full(pairs, WIDTH * LENGTH),
    surface=np.array("lap"),
    gap=np.zeros(pairs),
    penalty=np.full(pairs, 1e13),
    friction_coefficient=np.zeros(pairs),
)
tip = dofs - 2  # across the bar, at the end of the upper one
structure = Structure.from_matrices(
    K,
    M,
    contact,
    bolts={"left": dofs, "right": dofs + 1},
    inputs={"tip": tip},
    outputs={"tip": tip},
)

# %%
# From here on it is a structure like any other.

preload = apply_preload(structure, 5e3)
joint = connect_nodes(find_modes(structure, "all-8"), preload, 1e8, 0.2)
forces = [0.001, 0.01, 0.1]
response = solve_response(joint, forces, damping=0.001)

figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
left.bar(1e3 * x, preload["normal_load"], width=8)
left.set(xlabel="Place along the lower bar (mm)", ylabel="Normal load (N)")
for force, curve in by_force(response).groupby("force"):
    curve = curve.squeeze("force")
    right.semilogy(
        curve["frequency"], 1e3 * curve["response_amplitude"] / force, label=f"{force:g} N"
    )
right.set(xlabel="Frequency (Hz)", ylabel="Response per force (mm/N)", xlim=(18.4, 19.1))
right.legend()

# %%
# Total normal load over that of the bolts, and resonances in Hz:

print(round(preload["normal_load"].sum().item() / 10e3, 6))
print(response["peak_frequency"].round(2).values)
