"""Joints of regions and their error."""

from dataclasses import replace

import numpy as np
import pytest
from joint_examples import frozen_in_groups, grid
from small_joint import make_joint, make_preload

from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.joint.bands import bands_of_equal_load, bands_of_equal_middle_load
from boltjoint.joint.derived import merge_points
from boltjoint.joint.partition import choose_count, partition_regions, region_error

LAWS = ("constant", "variable")


@pytest.mark.parametrize("law", LAWS)
def test_equal_load_is_the_default_and_goes_by_the_load_of_the_elements(law):
    joint = make_joint(law=law)
    regions = partition_regions(joint, make_preload(joint), 4)
    expected = bands_of_equal_load(joint.position[:, :2], joint.law.slip_force, 4)
    np.testing.assert_array_equal(regions.law.point_of_element, expected)
    assert regions.points == 4
    for rows, of_pairs in zip(regions.rows, merge_points(joint, expected).rows, strict=True):
        np.testing.assert_array_equal(rows, of_pairs)


def joint_and_preload(law):
    """Three rows of pairs that carry load in places; those that do not have no constant element."""
    preload = make_preload(make_joint(pairs=402, law="variable"))
    surface = np.column_stack([grid(np.linspace(0, 0.1, 134), [-0.01, 0, 0.01]), np.zeros(402)])
    preload = preload.assign(position=(("pair", "axis"), surface))
    loaded = preload["normal_load"].to_numpy() > 0
    assert 100 < loaded.sum() < 300
    has_element = loaded if law == "constant" else np.ones(402, dtype=bool)
    joint = make_joint(pairs=has_element.sum(), law=law)
    return replace(joint, position=surface[has_element]), preload, has_element


@pytest.mark.parametrize("law", LAWS)
def test_equal_middle_load_goes_by_the_pressure_of_the_whole_surface(law):
    joint, preload, has_element = joint_and_preload(law)
    regions = partition_regions(joint, preload, 5, "equal-middle-load")
    surface = preload["position"].to_numpy()
    pressure = (preload["normal_load"] / preload["area"]).to_numpy()
    expected = bands_of_equal_middle_load(surface[:, :2], pressure, 5)
    np.testing.assert_array_equal(regions.law.point_of_element, expected[has_element])


def test_pressure_is_load_over_area():
    joint, preload, _ = joint_and_preload("variable")
    double = preload.assign(normal_load=2 * preload["normal_load"], area=2 * preload["area"])
    wider = preload["area"] * (1 + (preload["position"].sel(axis="x") > 0.05))
    same, other = (
        partition_regions(joint, one, 4, "equal-middle-load").law.point_of_element
        for one in (double, preload.assign(area=wider))
    )
    found = partition_regions(joint, preload, 4, "equal-middle-load").law.point_of_element
    np.testing.assert_array_equal(same, found)
    assert np.any(other != found)


@pytest.mark.parametrize("division", ["equal-load", "equal-middle-load", "clusters"])
def test_too_many_regions_are_refused(division):
    joint, preload, _ = joint_and_preload("variable")
    with pytest.raises(ValueError, match="do not divide into 403 regions"):
        partition_regions(joint, preload, 403, division)


@pytest.mark.parametrize("law", LAWS)
def test_clusters_do_not_depend_on_the_order_of_pairs(law):
    joint, preload = make_joint(law=law), make_preload(make_joint(law=law))
    shuffled = np.random.default_rng(0).permutation(joint.points)
    # points in another order; elements stay and find theirs
    other = replace(
        joint,
        tangential_mode=joint.tangential_mode[shuffled],
        normal_mode=None if joint.normal_mode is None else joint.normal_mode[shuffled],
        position=joint.position[shuffled],
        law=replace(joint.law, point_of_element=np.argsort(shuffled)),
    )
    one, two = (partition_regions(j, preload, 7, "clusters") for j in (joint, other))
    np.testing.assert_array_equal(one.law.point_of_element, two.law.point_of_element)


@pytest.mark.parametrize("law", LAWS)
def test_load_weighted_regions_keep_the_friction_of_full_slip(law):
    joint = make_joint(law=law)
    regions = partition_regions(joint, make_preload(joint), 5, motion="load-weighted")
    # modal force of all sliders moving the same way, which is what is left in macroslip
    force, of_pairs = (
        j.law.slip_force @ j.tangential_mode[j.law.point_of_element] for j in (regions, joint)
    )
    np.testing.assert_allclose(force, of_pairs, rtol=1e-12)  # but for rounding
    plain = partition_regions(joint, make_preload(joint), 5)
    assert np.any(
        np.abs(plain.law.slip_force @ plain.tangential_mode[plain.law.point_of_element] - of_pairs)
        > 1e-3 * np.abs(of_pairs)
    )


@pytest.mark.parametrize("law", LAWS)
def test_a_region_may_move_as_the_nearest_straight_line(law):
    joint = make_joint(law=law, pairs=40)
    count = 2
    lines = partition_regions(joint, make_preload(joint), count, motion="linear")
    region = bands_of_equal_load(joint.position[:, :2], joint.law.slip_force, count)
    for B, on_line in zip(joint.rows, lines.rows, strict=True):
        for each in range(count):
            x = joint.position[region == each, 0]
            for mode in range(B.shape[1]):
                line = np.polynomial.Polynomial.fit(x, B[region == each, mode], 1)
                np.testing.assert_allclose(
                    on_line[region == each, mode], line(x), atol=1e-12 * np.abs(B).max()
                )
    # what already lies on lines stays as it is, and nothing else of the joint changes
    again = partition_regions(lines, make_preload(joint), count, motion="linear")
    np.testing.assert_allclose(again.tangential_mode, lines.tangential_mode, rtol=1e-10)
    assert lines.law is joint.law
    assert lines.points == joint.points


def test_a_region_without_load_moves_as_the_mean():
    joint = make_joint(law="variable")
    law = joint.law
    opened = np.where(joint.position[:, 0] < 0.05, -1.0, np.abs(law.normal_load))
    joint = replace(joint, law=replace(law, normal_load=opened))
    preload, without = make_preload(joint), 0
    for count in (6, 12):
        plain, weighted = (
            partition_regions(joint, preload, count, "clusters", motion)
            for motion in ("mean", "load-weighted")
        )
        on = plain.law.point_of_element
        load = np.bincount(on, joint.law.slip_force)
        without += np.sum(load == 0)
        for one, other in zip(plain.rows, weighted.rows, strict=True):
            np.testing.assert_array_equal(one[load == 0], other[load == 0])
    assert without > 0


@pytest.mark.parametrize("law", LAWS)
def test_regions_of_one_pair_each_have_no_error(law):
    joint = make_joint(law=law)
    assert region_error(joint, merge_points(joint, np.arange(joint.points))) < 1e-12  # rounding


@pytest.mark.parametrize("law", LAWS)
def test_clusters_of_pairs_that_move_the_same_have_no_error(law):
    joint, _ = frozen_in_groups(law)
    bands, clusters = (
        region_error(joint, partition_regions(joint, make_preload(joint), 5, division))
        for division in ("equal-load", "clusters")
    )
    assert clusters < 1e-12 < 1e-4 < bands  # rounding; groups are all over the bands


@pytest.mark.parametrize("law", LAWS)
def test_the_error_is_at_least_that_of_the_stuck_joint(law):
    joint = make_joint(law=law)
    regions = partition_regions(joint, make_preload(joint), 3)

    def stuck(j):
        matrix = np.diag((2 * np.pi * j.natural_frequency) ** 2) + j.stuck_stiffness()
        return np.sqrt(np.linalg.eigvalsh(matrix)[0])

    assert region_error(joint, regions) >= abs(stuck(regions) / stuck(joint) - 1) > 1e-4


@pytest.mark.parametrize("division", ["equal-load", "clusters"])
def test_the_error_predicts_that_of_the_peaks(joint, division):
    preload = make_preload(joint)
    forces = (0.01, 1.0, 3.0, 6.0, 10.0)  # from stuck to all slipping

    def peaks(j):
        found = [solve_branch(j, force, damping=0.01) for force in forces]
        return np.array([branch.frequency[branch.peak] for branch in found])

    of_pairs = peaks(joint)
    for count in (2, 4):
        regions = partition_regions(joint, preload, count, division)
        largest = np.max(np.abs(peaks(regions) / of_pairs - 1))
        # the worst of the states is worse than where the peaks happen to lie, by up to 2.8 times
        assert largest < region_error(joint, regions) < 4 * largest


def test_joints_of_other_elements_are_not_compared(joint):
    with pytest.raises(ValueError, match="must have the elements"):
        region_error(joint, make_joint(pairs=50))


@pytest.mark.parametrize("law", LAWS)
def test_the_fewest_regions_within_the_tolerance_are_chosen(law):
    joint = make_joint(law=law)
    preload = make_preload(joint)
    chosen = choose_count(joint, preload, 0.004, "clusters")
    assert 2 < chosen < 60
    errors = [
        region_error(joint, partition_regions(joint, preload, count, "clusters"))
        for count in range(1, chosen + 1)
    ]
    assert errors[-1] <= 0.004 < min(errors[:-1])


@pytest.mark.parametrize("division", ["equal-load", "clusters"])
def test_regions_may_be_as_many_as_a_tolerance_asks_for(joint, division):
    preload = make_preload(joint)
    options = {"division": division, "motion": "load-weighted", "resonances": 2}
    regions = partition_regions(joint, preload, None, tolerance=0.01, **options)
    count = choose_count(joint, preload, 0.01, **options)
    assert regions.points == count > 2
    given = partition_regions(joint, preload, count, **options)
    np.testing.assert_array_equal(regions.tangential_mode, given.tangential_mode)
    np.testing.assert_array_equal(regions.law.point_of_element, given.law.point_of_element)
    assert region_error(joint, regions, resonances=2) <= 0.01
    # a wider one asks for fewer
    assert partition_regions(joint, preload, None, tolerance=0.05, **options).points < count


def test_a_number_goes_before_a_tolerance(joint):
    assert partition_regions(joint, make_preload(joint), 3, tolerance=1e-9).points == 3


def test_regions_need_a_number_or_a_tolerance(joint):
    with pytest.raises(ValueError, match="need a number, or a tolerance that chooses it"):
        partition_regions(joint, make_preload(joint), None)


def test_a_tolerance_that_is_not_met_is_refused(joint):
    with pytest.raises(ValueError, match=r"up to 3 regions \(clusters, mean\) have an error of"):
        choose_count(joint, make_preload(joint), 1e-4, "clusters", maximum=3)
    with pytest.raises(ValueError, match=r"tolerance is 0\.0: it must be positive"):
        choose_count(joint, make_preload(joint), 0.0)
