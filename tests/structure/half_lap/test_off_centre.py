"""Bolts off the centre line and a shaker off the plane: against CalculiX and matrices."""

from dataclasses import replace

import numpy as np
import pytest
from examples import off_centre
from scipy.sparse import diags_array
from scipy.sparse.linalg import splu

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.calculix_program import run
from boltjoint.structure.makers.half_lap.calculix import (
    read_modes,
    read_preload,
    write_modes_deck,
    write_preload_deck,
)
from boltjoint.structure.makers.half_lap.comparison_with_calculix import compare_with_calculix
from boltjoint.structure.makers.half_lap.structure import structure_of
from boltjoint.structure.model import Row
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

PRELOAD, MODES = 8e3, 7


def whole_of(assembly):
    """The structure of a mesh without symmetry, whose modes are of no family."""
    structure = structure_of(assembly)
    assert structure.symmetry is None
    return replace(structure, maker="")


@pytest.mark.usefixtures("installed")
def test_calculix_finds_the_same_for_bolts_off_the_centre_line(assembly, tmp_path):
    mesh = off_centre(assembly)
    structure = whole_of(mesh)
    modes = find_modes(structure, f"all-{MODES}")
    preload = apply_preload(structure, PRELOAD)
    for name, write, value in (
        ("modes", write_modes_deck, MODES + 1),
        ("preload", write_preload_deck, PRELOAD),
    ):
        write(mesh, value, tmp_path / f"{name}.inp")
        run(tmp_path / f"{name}.inp", tmp_path / f"{name}.log")
    others = read_modes(mesh, tmp_path / "modes.dat"), read_preload(mesh, tmp_path / "preload.dat")
    table = compare_with_calculix(mesh, modes, preload, *others).set_index("quantity")
    frequencies = table.index.str.startswith("natural frequency")
    # the bounds of the mesh with its bolts on the centre line
    assert abs(table.loc[frequencies, "difference_percent"]).max() < 0.5
    assert table.loc[frequencies, "likeness"].min() > 0.99
    assert abs(table.loc["normal load of all pairs", "difference_percent"]) < 0.01
    for field in ("largest normal load of a pair", "largest gap of a pair"):
        assert abs(table.loc[field, "difference_percent"]) < 1.0
        assert table.loc[field, "likeness"] > 0.999
    assert table.loc["pairs in contact", "likeness"] > 0.98
    assert table.loc["friction force of all pairs, without direction", "likeness"] > 0.99
    # loads are not those of bolts on the centre line
    straight = apply_preload(assembly, PRELOAD)["normal_load"].to_numpy()
    load = preload["normal_load"].to_numpy()
    assert np.corrcoef(load, straight)[0, 1] < 0.95


def corner(mesh, side):
    """A node at the top of the free end, on one side of the bar."""
    x, y, z = mesh["coordinate"].to_numpy().T
    return int(np.argmax(x + 1e-3 * side * y + 1e-6 * z * (abs(z) < 0.0101)))


@pytest.mark.parametrize("bolts", ["on the centre line", "beside it"])
def test_a_shaker_off_the_plane_excites_all_that_matrices_say(tiny, bolts):
    """The stuck linear response by all modes against the matrices themselves."""
    mesh = tiny if bolts == "on the centre line" else off_centre(tiny)
    own = structure_of(mesh)
    # along z, at opposite corners of the free end
    shaker, sensor = (
        own.geometry.displacement.tocsr()[[3 * corner(mesh, side) + 2]].toarray()[0]
        for side in (1, -1)
    )
    structure = replace(
        own, maker="", inputs={"shaker": Row(shaker, "z")}, outputs={"sensor": Row(sensor, "z")}
    )
    assert (structure.symmetry is not None) == (bolts == "on the centre line")
    modes = find_modes(structure, f"all-{structure.moving.size}")
    tangential, normal, loss_factor, force = 3e7, 5e7, 0.01, 2.0
    preload = apply_preload(structure, PRELOAD)
    joint = connect_nodes(modes, preload, tangential, 0.1, normal)

    moving = structure.moving
    K, M = (each[moving][:, moving] for each in (structure.stiffness, structure.mass))
    # friction of the law acts along the first tangent
    closed = preload["normal_load"].to_numpy() > 0
    spring = np.outer(closed, [tangential, 0, normal]).ravel()
    C = structure.contact.relative[:, moving]
    contact = C.T @ diags_array(spring) @ C
    balance = HarmonicBalance(joint, loss_factor, force)
    sin, cos = (balance.components.index(name) for name in ("sin", "cos"))
    for frequency in joint.resonance_range()[:3, 1] * 1.01:
        w = 2 * np.pi * frequency
        D = ((1 + 1j * loss_factor) * K + contact - w**2 * M).tocsc()
        expected = force * sensor[moving] @ splu(D).solve(shaker[moving] + 0j)
        x = balance.stuck_solution(w).reshape(len(balance.components), -1)
        found = (x[sin] + 1j * x[cos]) @ joint.response_mode
        assert found == pytest.approx(expected, rel=1e-7)
    # half of the modes are those that a shaker on the plane leaves at rest
    moved = abs(joint.excitation_mode[:6]) > 1e-3 * abs(joint.excitation_mode[:6]).max()
    assert moved.all()
