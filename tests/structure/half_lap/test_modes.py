"""Modes: normalisation, classification, choice, signs, and the published frequencies."""

import numpy as np
import pytest
from examples import coarse_assembly, study_assembly
from scipy import sparse
from scipy.linalg import eigh

from boltjoint.config.lap_joint import LapJoint
from boltjoint.dataset import save
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.makers.half_lap.families import classify, symmetric_share
from boltjoint.structure.makers.half_lap.mesh import build_assembly
from boltjoint.structure.makers.half_lap.structure import assemble_assembly, structure_of
from boltjoint.structure.model import Structure
from boltjoint.structure.modes import find_modes
from boltjoint.structure.subspaces import whole


def test_modes_are_normalised_by_mass_and_solve_the_eigenproblem(assembly, modes):
    K, M = assemble_assembly(assembly)
    shape = modes["mode_shape"].to_numpy().reshape(K.shape[0], -1)
    squared = (2 * np.pi * modes["natural_frequency"].to_numpy()) ** 2
    np.testing.assert_allclose(shape.T @ M @ shape, np.eye(3), atol=1e-10)
    np.testing.assert_allclose(shape.T @ K @ shape, np.diag(squared), atol=1e-9 * squared.max())


def test_modes_keep_the_clamp_and_the_closed_sections(assembly, modes):
    shape = modes["mode_shape"].to_numpy()
    nut, head = assembly["section_node"].to_numpy().T
    assert not shape[assembly["clamped_node"].to_numpy()].any()
    np.testing.assert_array_equal(shape[nut], shape[head])


def test_relative_modes_are_side_a_minus_side_b(assembly, modes):
    a, b = assembly["pair_node"].to_numpy().T
    shape = modes["mode_shape"].to_numpy()
    np.testing.assert_array_equal(modes["relative_mode"], shape[a] - shape[b])
    # without contact the bars slide on one another
    assert abs(modes["relative_mode"].sel(axis="x")).max() > 1e-3


def test_excited_and_observed_entries(assembly, modes):
    for name in ("excitation", "response"):
        node = assembly[f"{name}_node"].item()
        np.testing.assert_array_equal(
            modes[f"{name}_mode"], modes["mode_shape"].sel(axis="z")[node]
        )
    assert modes["response_mode"].min() > 0


def test_chosen_modes_are_the_first_bending_ones(modes):
    frequency = modes["candidate_frequency"].to_numpy()
    assert np.all(np.diff(frequency) > 0)
    bending = frequency[modes["candidate_family"].to_numpy() == "bending"]
    np.testing.assert_array_equal(modes["natural_frequency"], bending[:3])
    np.testing.assert_allclose(modes["energy_share"].sum("axis"), 1, rtol=1e-12)
    # the mesh is symmetric, so every mode is wholly one or the other
    share = modes["symmetric_share"].to_numpy()
    np.testing.assert_allclose(np.minimum(share, 1 - share), 0, atol=1e-9)


def test_search_goes_on_until_enough_bending_modes_are_found(assembly, modes):
    many = find_modes(assembly, "free-12")
    assert many.sizes["mode"] == 12
    assert np.sum(many["candidate_family"] == "bending") >= 12
    # another number of vectors, another path to the same modes
    np.testing.assert_allclose(many["natural_frequency"][:3], modes["natural_frequency"], rtol=1e-9)
    np.testing.assert_allclose(many["response_mode"][:3], modes["response_mode"], rtol=1e-6)


def test_halves_have_the_modes_of_the_whole(assembly, modes):
    structure = structure_of(assembly)
    both = whole(structure, tightened=False)
    found = modes["candidate_frequency"].to_numpy()
    squared, x = both.modes(both.factors(both.stiffness), both.stiffness, found.size)
    np.testing.assert_allclose(found, np.sqrt(squared) / (2 * np.pi), rtol=1e-8)
    shape = structure.geometry.shape(both.basis @ x)
    for frequency, ours in zip(
        modes["natural_frequency"], modes["mode_shape"].transpose("mode", ...), strict=True
    ):
        theirs = shape[..., np.flatnonzero(found == frequency.item())[0]]
        sign = np.sign(np.vdot(theirs, ours))
        np.testing.assert_allclose(ours, sign * theirs, atol=1e-6)


def test_all_families_are_the_lowest_modes_of_both_halves(assembly, modes):
    found = find_modes(assembly, "all-8")
    frequency = found["natural_frequency"].to_numpy()
    assert np.all(np.diff(frequency) > 0)
    family = found["candidate_family"].to_numpy()
    assert {"bending", "lateral"} < set(family)
    # those that bend are the same, and none is left out below the last
    bending = frequency[family == "bending"][: modes.sizes["mode"]]
    np.testing.assert_allclose(bending, modes["natural_frequency"][: bending.size], rtol=1e-9)
    beside = modes["candidate_frequency"][modes["candidate_family"] != "bending"]
    for other in beside[beside < frequency[-1]].to_numpy():
        assert np.isclose(frequency, other, rtol=1e-9).any()


def test_of_many_only_symmetric_ones_are_sought(assembly):
    many = find_modes(assembly, "free-13")
    np.testing.assert_allclose(many["symmetric_share"], 1, rtol=1e-12)
    assert set(many["candidate_family"].to_numpy()) == {"bending", "axial"}


@pytest.mark.parametrize(
    ("energy_share", "symmetric", "family"),
    [
        ([0.02, 0.00, 0.98], 1.0, "bending"),
        ([0.27, 0.00, 0.73], 1.0, "bending"),
        ([0.73, 0.00, 0.27], 1.0, "axial"),  # 1562 Hz of the three-bolt assembly
        ([0.02, 0.98, 0.00], 0.0, "lateral"),
        ([0.00, 0.53, 0.47], 0.0, "torsional"),
    ],
)
def test_families_of_modes(energy_share, symmetric, family):
    found = classify(np.array([energy_share]), np.array([symmetric]), 0.02, 0.02)
    assert found.tolist() == [family]


@pytest.mark.parametrize("height", [0.005, 0.02, 0.08])
def test_a_twisting_bar_is_torsional_whatever_its_section(height):
    width = 0.02
    share = np.array([[0.0, height**2, width**2]]) / (height**2 + width**2)
    assert classify(share, np.zeros(1), width, height).tolist() == ["torsional"]


def test_symmetry_is_seen_on_the_middle_plane():
    x, y, z = np.meshgrid([0.0, 1.0], [-1.0, 0.0, 1.0], [-1.0, 1.0], indexing="ij")
    coordinate = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    x, y, z = coordinate.T
    zero = np.zeros_like(x)
    bend, lateral, twist = ([-x * z, zero, x], [-x * y, x, zero], [zero, -x * z, x * y])
    shape = np.transpose([bend, lateral, twist], (2, 1, 0))
    np.testing.assert_array_equal(symmetric_share(coordinate, np.ones(12), shape), [1, 0, 0])
    with pytest.raises(ValueError, match="no nodes lie on the middle plane"):
        symmetric_share(coordinate[y != 0], np.ones(8), shape[y != 0])


@pytest.mark.parametrize(
    ("point", "message"),
    [
        ("excitation", "this force does not excite the selected modes: excitation"),
        ("response", "the output point does not move in the selected modes: output"),
    ],
)
@pytest.mark.parametrize("family", ["free-2", "free-13"])
def test_refuses_points_that_the_modes_leave_at_rest(assembly, point, message, family):
    across, held = assembly.copy(deep=True), assembly.copy(deep=True)
    # across the width of a symmetric assembly, and in its clamp
    across[f"{point}_node"].attrs["direction"] = "y"
    held[f"{point}_node"][...] = held["clamped_node"][0]
    for each in (across, held):
        with pytest.raises(ValueError, match=f"{message} moves in none of"):
            find_modes(each, family)


@pytest.mark.parametrize("family", ["free", "free-0", "free-04", "Free-4", "stuck-4", "free-4 "])
def test_refuses_unknown_families(assembly, family):
    with pytest.raises(ValueError, match="allowed: free-N"):
        find_modes(assembly, family)


def test_every_variable_has_units(modes, tmp_path):
    save(modes, tmp_path / "modes.nc")


def test_result_is_the_same_every_time(assembly, modes):
    assert modes.identical(find_modes(assembly, "free-3"))


@pytest.mark.parametrize(
    ("name", "published"),
    [("three_bolt", [71, 362, 946, 2571]), ("four_bolt", [51, 263, 731, 1899])],
)
def test_published_frequencies(name, published, monkeypatch):
    # only symmetric ones are compared
    monkeypatch.setattr("boltjoint.structure.modes._MOST_BESIDE_OTHERS", 0)
    found = find_modes(build_assembly(study_assembly(name)), "free-4")
    # the dimensions were calibrated on the published values, which have two or three digits
    np.testing.assert_allclose(found["natural_frequency"], published, rtol=0.01)
    left_out = found["candidate_family"].to_numpy()[found["candidate_frequency"] < 2600] == "axial"
    assert left_out.sum() == 1


@pytest.mark.parametrize("family", ["free-3", "free-20"])
def test_an_assembly_that_is_not_held_moves_as_a_rigid_body(assembly, family):
    loose = find_modes(assembly.isel(clamped=slice(0, 0)), family)
    frequency = loose["natural_frequency"].to_numpy()
    assert not frequency[:6].any()
    assert frequency[6] > 100
    relative = loose["relative_mode"].to_numpy()
    np.testing.assert_allclose(relative[..., :6], 0, atol=1e-9 * abs(relative).max())


def test_a_slow_structure_is_no_loose_one():
    # two metres long: its first frequency is 1/60 of the other assemblies'
    slender = coarse_assembly().model_dump()
    slender["bar"]["free_length_mm"] = (1000, 1000)
    slender["mesh"]["element_length_free_mm"] = 25
    found = find_modes(build_assembly(LapJoint.model_validate(slender)), "free-2")
    assert 1 < found["natural_frequency"][0] < 5


@pytest.mark.parametrize("held", [True, False])
def test_few_degrees_of_freedom_have_all_their_modes(held):
    """A chain of four masses, held or free, with a massless joint and a pair of contact."""
    K = 1e6 * (2 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1))
    K[4, 4] = 1e6
    K[0, 0] = 2e6 if held else 1e6
    M = np.diag([1.0, 2.0, 0.0, 1.5, 1.0])
    # directions of the contact that the chain has not are at rest
    rows = np.zeros((3, 5))
    rows[0, [1, 3]] = 1, -1
    contact = ContactPoints(
        sparse.csr_array(rows), [[0, 0, 0]], [np.eye(3)], [1e-4], "one", [0.0], [1e12], [0.1]
    )
    chain = Structure.from_matrices(K, M, contact, inputs={"force": 4}, outputs={"end": 4})
    found = find_modes(chain, f"all-{4 if held else 3}")["natural_frequency"].to_numpy()
    # the massless joint follows by statics
    with_mass = [0, 1, 3, 4]
    row = K[2, with_mass]
    condensed = K[np.ix_(with_mass, with_mass)] - np.outer(row, row) / K[2, 2]
    squared = eigh(condensed, np.diag(M.diagonal()[with_mass]), eigvals_only=True)
    if not held:
        assert found[0] == 0
        found, squared = found[1:], squared[1:]
    np.testing.assert_allclose((2 * np.pi * found) ** 2, squared, rtol=1e-9)
    with pytest.raises(ValueError, match="not as many modes"):
        find_modes(chain, "all-5")
