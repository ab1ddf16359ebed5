"""Decks beside CalculiX, where it is installed: ties of unlike meshes, couplings, rigid bodies."""

import re
import subprocess

import numpy as np
import pytest
from scipy.linalg import eigh

from boltjoint.structure.elements.matrices import ElementOptions
from boltjoint.structure.makers.deck.assembled import constrain, matrices
from boltjoint.structure.makers.deck.mesh import mesh_of
from boltjoint.structure.makers.deck.reader import read_deck


def block(name, divisions, low, high, first):
    """Nodes and bricks of a block, with its faces S1 and S2 as surfaces."""
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, divisions, strict=True)]
    x, y, z = (each.ravel() for each in np.meshgrid(*axes, indexing="ij"))
    nx, ny, nz = (n + 1 for n in divisions)
    number = first + np.arange(nx * ny * nz).reshape(nx, ny, nz)
    nodes = "".join(
        f"{i}, {a!r}, {b!r}, {c!r}\n"
        for i, a, b, c in zip(
            number.ravel().tolist(), x.tolist(), y.tolist(), z.tolist(), strict=True
        )
    )
    corner = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    corner += [(a, b, 1) for a, b, _ in corner]
    bricks, low_faces, high_faces = [], [], []
    for i, j, k in np.ndindex(*divisions):
        label = first + len(bricks)
        places = ", ".join(str(number[i + a, j + b, k + c]) for a, b, c in corner)
        bricks.append(f"{label}, {places}\n")
        low_faces += [f"{label}, S1\n"] if k == 0 else []
        high_faces += [f"{label}, S2\n"] if k == divisions[2] - 1 else []
    ends = "".join(f"{each},\n" for each in number[:, :, 0].ravel())
    return (
        f"*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET={name}\n{''.join(bricks)}"
        f"*SURFACE, NAME={name}LOW\n{''.join(low_faces)}*SURFACE, NAME={name}HIGH\n"
        f"{''.join(high_faces)}*NSET, NSET={name}END\n{ends}"
        f"*SOLID SECTION, ELSET={name}, MATERIAL=STEEL\n"
    )


HEAD = "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., .3\n*DENSITY\n7.8E-9\n"
BLOCKS = (
    block("LOWER", (2, 2, 3), (0, 0, 0), (20, 20, 30), 1)
    + block("UPPER", (3, 3, 2), (2, 1, 30), (18, 19, 50), 1001)
    + HEAD
)
HELD = "*BOUNDARY\nLOWEREND, 1, 3\n"
DECKS = {
    "a tie of unlike meshes": "*TIE, NAME=GLUE, POSITION TOLERANCE=1., ADJUST=NO\nUPPERLOW, "
    "LOWERHIGH\n" + HELD,
    "a rigid body": "*NODE\n5000, 10., 10., 55.\n*NSET, NSET=TOP\n5000\n*TIE, NAME=GLUE, "
    "POSITION TOLERANCE=1., ADJUST=NO\nUPPERLOW, LOWERHIGH\n*NSET, NSET=HIGH, GENERATE\n"
    "1003, 1048, 3\n*RIGID BODY, NSET=HIGH, REF NODE=5000\n" + HELD,
}


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("case", DECKS)
def test_constrained_bodies_have_the_frequencies_of_calculix(case, tmp_path):
    text = BLOCKS + DECKS[case]
    step = "*STEP\n*FREQUENCY\n6\n*END STEP\n"
    (tmp_path / "joint.inp").write_text(text + step)
    subprocess.run(["ccx", "joint"], cwd=tmp_path, check=True, capture_output=True, timeout=60)
    rows = re.findall(
        r"^\s+\d+\s+\S+E\S+\s+\S+E\S+\s+(\S+)", (tmp_path / "joint.dat").read_text(), re.M
    )
    expected = np.array(rows[:6], dtype=float)
    deck = read_deck(tmp_path, "joint.inp")
    found = constrain(mesh_of(deck, 1e-3), boundaries=deck.boundaries)
    K, M = matrices(found, ElementOptions(), 1e6, 1e12)
    T = found.elimination.transformation
    K, M = ((T.T @ each @ T).toarray() for each in (K, M))
    acting = np.flatnonzero(K.diagonal())
    squared = eigh(K[np.ix_(acting, acting)], M[np.ix_(acting, acting)], eigvals_only=True)
    # CalculiX writes eight digits, and single precision lies between
    np.testing.assert_allclose(np.sqrt(squared[:6]) / (2 * np.pi), expected, rtol=1e-5)
