"""Initial gap of the contact: its shape, closed forms of contact that closes one, and preload."""

from itertools import pairwise

import examples
import numpy as np
import pytest
from scipy import sparse

from boltjoint.config.gap_map import GapMap
from boltjoint.config.lap_joint import LapJoint
from boltjoint.dataset import load, quantity, save
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.contact_equilibrium import contact_force, solve_contact
from boltjoint.structure.makers.half_lap.calculix import write_preload_deck
from boltjoint.structure.makers.half_lap.mesh import build_assembly
from boltjoint.structure.makers.half_lap.structure import (
    assemble_assembly,
    free_displacements,
    relative_displacements,
    structure_of,
)
from boltjoint.structure.preload import apply_preload

#: the lap of the coarse assembly [m]
LAP, WIDTH = 70e-3, 20e-3


def with_gap(gap, **mesh):
    """The coarse assembly with a gap between its surfaces."""
    plain = examples.coarse_assembly(**mesh).model_dump()
    return LapJoint.model_validate(plain | {"contact": {"gap_um": gap}})


def with_field(assembly, field):
    return assembly.assign(initial_gap=quantity("pair", field, "m", "initial gap"))


@pytest.fixture(scope="module")
def hollow():
    return build_assembly(with_gap({"flatness_um": 5}))


@pytest.fixture(scope="module")
def closed(hollow):
    return apply_preload(hollow, 8e3)


def from_centre(assembly):
    x, y, _ = assembly["position"].transpose("axis", "pair").to_numpy()
    return x - (x.min() + x.max()) / 2, y


def test_surfaces_are_flat_hollow_crowned_or_wavy(assembly, hollow):
    assert "initial_gap" not in assembly
    x, y = from_centre(hollow)
    outwards = (x**2 + y**2) / ((LAP / 2) ** 2 + (WIDTH / 2) ** 2)
    np.testing.assert_allclose(hollow["initial_gap"], 5e-6 * (1 - outwards), atol=1e-18)
    crowned = build_assembly(with_gap({"flatness_um": -5}))["initial_gap"].to_numpy()
    # the bolts are not in the middle of the lap, and no pair is at its centre
    np.testing.assert_allclose(crowned, 5e-6 * (outwards - outwards.min()), atol=1e-18)
    wavy = {"flatness_um": 5, "waviness_um": 2, "wavelength_mm": 35}
    wave = 2e-6 * np.cos(2 * np.pi * x / 0.035)
    field = wave - 5e-6 * outwards
    found = build_assembly(with_gap(wavy))["initial_gap"].to_numpy()
    np.testing.assert_allclose(found, field - field.min(), atol=1e-18)
    assert found.min() == 0


def mirror_images(assembly):
    position = np.round(assembly["position"].transpose("pair", "axis").to_numpy(), 12)
    place = {tuple(row): n for n, row in enumerate((position + 0.0).tolist())}
    return [place[tuple(row)] for row in (position * [1, -1, 1] + 0.0).tolist()]


def test_a_map_has_the_gap_of_its_interpolant_the_same_on_both_sides(hollow):
    x, y = map(np.ravel, np.meshgrid([-40, -10, 15, 40], [-12, -5, 5, 12], indexing="ij"))
    config = with_gap("map.csv")
    # a plane at the middle, and a ridge along it
    gap_map = GapMap(x, y, 7 + 0.05 * x + 0.3 * abs(y))
    found = build_assembly(config, gap_map)["initial_gap"].to_numpy()
    away, across = from_centre(hollow)
    # bilinear between the lines of points
    field = 0.05 * 1e3 * away + 0.3 * np.maximum(1e3 * abs(across), 5)
    np.testing.assert_allclose(found, 1e-6 * (field - field.min()), atol=1e-18)
    for each in (found, hollow["initial_gap"].to_numpy()):
        np.testing.assert_array_equal(each, each[mirror_images(hollow)])


def test_a_map_that_is_missing_or_does_not_suit_the_lap_is_refused():
    config = with_gap("map.csv", **examples.FEWEST)
    with pytest.raises(ValueError, match=r"gap_map is None: contact\.gap_um needs the map in map"):
        build_assembly(config)
    x, y = map(np.ravel, np.meshgrid([-30.0, 30.0], [-12.0, 12.0]))
    with pytest.raises(ValueError, match="gap_map has no value at x = -35, y = -10 mm"):
        build_assembly(config, GapMap(x, y, 0 * x))
    with pytest.raises(ValueError, match="gap_map differs by 20 um on both sides"):
        build_assembly(config, GapMap(2 * x, y, y))


def test_two_springs_close_a_gap_and_then_share_the_load():
    structure, contact, gap = 2e6, 8e6, 3e-6
    K = sparse.csc_array([[structure]])
    C = sparse.csr_array([[0.0], [0.0], [1.0]])
    for force in (1.0, 5.999, 6.001, 60.0):
        found = solve_contact(K, C, np.array([contact]), 0.0, np.array([force]), gap=[gap])
        beyond = max(force - structure * gap, 0.0)
        load = contact * beyond / (structure + contact)
        assert found.converged
        assert found.force[0, 2] == pytest.approx(load, abs=1e-9 * force)
        assert found.unknown[0] == pytest.approx((force - load) / structure, rel=1e-9)


def test_the_law_with_a_gap_is_that_without_one_moved_along_the_normal():
    rng = np.random.default_rng(3)
    relative, stiffness = rng.uniform(-1, 1, (50, 3)), rng.uniform(0.5, 2, 50)
    gap = rng.uniform(0, 0.5, 50)
    moved = relative - np.c_[0 * gap, 0 * gap, gap]
    for one, other in zip(
        contact_force(relative, stiffness, 0.4, gap),
        contact_force(moved, stiffness, 0.4),
        strict=True,
    ):
        np.testing.assert_array_equal(one, other)


def test_a_rigid_paraboloid_presses_into_its_springs():
    # Winkler foundation of stiffness k per area under a rigid surface x^2 / 2R: where it is pressed
    # in by d, the contact is |x| < a = sqrt(2 R d), the pressure k (a^2 - x^2) / 2R and the force
    # 2/3 k W a^3 / R (Johnson, Contact Mechanics, 1985, section 4.3).
    L, W, penalty, R, a = 0.04, 0.01, 1e10, 50.0, 0.012
    K, C, stiffness, area, coordinate, base = examples.block_on_ground((80, 1, 2), 1e12, penalty)
    x = coordinate[base, 0] - L / 2
    force = np.zeros(K.shape[0])
    top = np.flatnonzero(np.isclose(coordinate[:, 2], 0.01))
    force[3 * top + 2] = -2 / 3 * penalty * W * a**3 / R * area / area.sum()
    # friction holds the block; rounding leaves 2e-9 of the force unbalanced
    found = solve_contact(K, C, stiffness, 0.3, force, gap=x**2 / (2 * R), tolerance=1e-8)
    pressure = found.force[:, 2] / area
    exact = penalty * np.maximum(a**2 - x**2, 0) / (2 * R)
    assert found.converged
    # the edge of the contact falls between two of 80 nodes, and the block is not quite rigid
    np.testing.assert_allclose(pressure, exact, atol=1e-3 * exact.max())


def test_a_gap_that_is_the_same_everywhere_only_lengthens_the_way(assembly, preload):
    found = apply_preload(with_field(assembly, np.full(assembly.sizes["pair"], 5e-6)), 8e3)
    # both leave 1e-10 of the preload unbalanced
    np.testing.assert_allclose(found["normal_load"], preload["normal_load"], atol=1e-5)
    np.testing.assert_allclose(found["gap"], preload["gap"], atol=1e-12)
    way = found["shank_shortening"] - preload["shank_shortening"]
    np.testing.assert_allclose(way, 5e-6, rtol=1e-6)


def test_no_gap_has_the_bytes_of_flat_surfaces(assembly, preload):
    found = apply_preload(with_field(assembly, np.zeros(assembly.sizes["pair"])), 8e3)
    assert found.identical(preload)


def test_twice_the_preload_and_the_gap_double_everything(hollow, closed):
    twice = with_field(hollow, 2 * hollow["initial_gap"].to_numpy())
    doubled = apply_preload(twice, 16e3)
    for name in ("normal_load", "gap", "friction_force", "shank_shortening", "displacement"):
        np.testing.assert_array_equal(doubled[name], 2 * closed[name])


def test_a_small_gap_moves_loads_in_proportion(assembly, preload):
    x, y = from_centre(assembly)
    field = 1 - (x**2 + y**2) / ((LAP / 2) ** 2 + (WIDTH / 2) ** 2)
    flat = apply_preload(assembly, 8e3, tolerance=1e-12)["normal_load"]
    moved = []
    for size in (1e-9, 1e-10):
        found = apply_preload(with_field(assembly, size * field), 8e3, tolerance=1e-12)
        moved.append(abs(found["normal_load"] - flat).max().item())
    assert moved[1] < 1e-4 * preload["normal_load"].max().item()
    # as long as the same pairs are closed
    assert moved[0] / moved[1] == pytest.approx(10, rel=1e-2)


@pytest.mark.parametrize("flatness", [-50e-6, -5e-6, 5e-6, 100e-6])
def test_loads_add_up_to_the_bolts_whatever_the_gap(assembly, flatness):
    x, y = from_centre(assembly)
    field = -flatness * (x**2 + y**2) / ((LAP / 2) ** 2 + (WIDTH / 2) ** 2)
    gap = field - field.min()
    found = apply_preload(with_field(assembly, gap), 8e3)
    load, opening = found["normal_load"].to_numpy(), found["gap"].to_numpy()
    assert load.sum() == pytest.approx(16e3, rel=1e-8)
    np.testing.assert_array_equal(load > 0, opening == 0)
    assert found["iterations"] <= 25
    # what is left open is the gap and what the bars have moved apart
    u, (a, b) = found["displacement"].to_numpy(), assembly["pair_node"].to_numpy().T
    away = (gap + u[b, 2] - u[a, 2])[opening > 0]
    np.testing.assert_allclose(away, opening[opening > 0], rtol=1e-9)


@pytest.mark.parametrize("friction_coefficient", [0.01, 0.5])
@pytest.mark.parametrize("preload_N", [500.0, 8e3])
def test_rough_surfaces_that_touch_in_few_pairs_converge(assembly, preload_N, friction_coefficient):
    # without springs on open pairs the bars part on the way, and the search fails
    x, y = from_centre(assembly)
    x, y = np.round(x, 12), np.round(abs(y), 12)
    wave = np.cos(2 * np.pi * x / 0.023 + 1) * np.cos(2 * np.pi * y / 0.013) + np.sin(190 * x)
    rough = with_field(assembly, 20e-6 * (wave - wave.min()) / np.ptp(wave))
    mu = friction_coefficient + 0 * assembly["friction_coefficient"]
    found = apply_preload(rough.assign(friction_coefficient=mu), preload_N)
    load = found["normal_load"].to_numpy()
    assert load.sum() == pytest.approx(2 * preload_N, rel=1e-7)
    assert 0 < np.mean(load > 0) < 0.5
    assert found["residual"][-1] <= 1e-10
    friction = np.linalg.norm(found["friction_force"], axis=1)
    assert np.all(friction <= friction_coefficient * load * (1 + 1e-12))


def test_a_hollow_joint_closes_from_its_ends(assembly):
    x, y = from_centre(assembly)
    gap = 100e-6 * (1 - (x**2 + y**2) / ((LAP / 2) ** 2 + (WIDTH / 2) ** 2))
    loaded = [
        apply_preload(with_field(assembly, gap), newton)["normal_load"].to_numpy() > 0
        for newton in (50.0, 2e3, 20e3)
    ]
    assert abs(x[loaded[0]]).min() > 0.03
    for less, more in pairwise(loaded):
        assert np.count_nonzero(less) < np.count_nonzero(more)
        # the ends stay in contact as the middle comes into it
        assert np.median(abs(x[less])) > np.median(abs(x[more]))


def test_the_symmetric_half_has_the_equilibrium_of_the_whole(hollow):
    half = apply_preload(hollow, 8e3, tolerance=1e-12)
    T = free_displacements(hollow, tightened=True)
    force = np.zeros(T.shape[1])
    force[-hollow.sizes["bolt"] :] = 8e3
    whole = solve_contact(
        (T.T @ assemble_assembly(hollow)[0] @ T).tocsc(),
        relative_displacements(hollow) @ T,
        hollow["contact_penalty"].item() * hollow["area"].to_numpy(),
        hollow["friction_coefficient"].item(),
        force,
        gap=hollow["initial_gap"].to_numpy(),
        tolerance=1e-12,
    )
    np.testing.assert_allclose(half["normal_load"], whole.force[:, 2], atol=1e-7)
    np.testing.assert_allclose(half["friction_force"], whole.force[:, :2], atol=1e-7)


def test_a_gap_that_is_not_symmetric_is_closed_in_the_whole(hollow):
    _, y = from_centre(hollow)
    gap = hollow["initial_gap"].to_numpy()
    one, other = (
        apply_preload(with_field(hollow, gap + 2e-6 * (side * y > 1e-9)), 8e3)["normal_load"]
        for side in (1, -1)
    )
    assert one.sum().item() == pytest.approx(16e3, rel=1e-7)
    assert one[y < 0].sum() > 1.01 * one[y > 0].sum()
    image = structure_of(hollow).symmetry.point
    np.testing.assert_allclose(one, other[image], atol=1e-6)


def test_a_gap_that_is_negative_is_refused(hollow):
    gap = hollow["initial_gap"].to_numpy()
    with pytest.raises(ValueError, match="initial_gap of assembly"):
        apply_preload(with_field(hollow, gap - 1e-9), 8e3)


def test_results_keep_the_initial_gap(hollow, closed, tmp_path):
    save(closed, tmp_path / "preload.nc")
    np.testing.assert_array_equal(
        load(tmp_path / "preload.nc")["initial_gap"], hollow["initial_gap"]
    )
    assert closed["initial_gap"].attrs["units"] == "m"


def test_laws_have_the_contact_that_the_gap_leaves(modes, preload, closed):
    keys = {"tangential_stiffness": 1e8, "friction_coefficient": 0.1}
    load, opening = closed["normal_load"].to_numpy(), closed["gap"].to_numpy()
    constant = connect_nodes(modes, closed, **keys)
    np.testing.assert_array_equal(constant.law.slip_force, 0.1 * load[load > 0])
    assert constant.points != np.count_nonzero(preload["normal_load"])
    variable = connect_nodes(modes, closed, **keys, normal_stiffness=2e8)
    np.testing.assert_array_equal(
        variable.law.normal_load, np.where(load > 0, load, -2e8 * opening)
    )
    # both sides of the middle are alike, as without a gap
    for joint, without in (
        (variable, connect_nodes(modes, preload, **keys, normal_stiffness=2e8)),
    ):
        assert joint.distinct.points == without.distinct.points < 0.65 * joint.points


def test_decks_refuse_what_they_do_not_hold(hollow, tmp_path):
    with pytest.raises(ValueError, match="assembly has an initial gap, which decks do not hold"):
        write_preload_deck(hollow, 8e3, tmp_path / "deck.inp")
