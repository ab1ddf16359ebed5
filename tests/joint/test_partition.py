from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint, make_preload

from boltjoint.dynamics.frequency_response import solve_branch
from boltjoint.joint.bands import (
    bands_of_equal_load,
    bands_of_equal_middle_load,
    inner_and_outer_bands,
)
from boltjoint.joint.clusters import cluster_by_motion
from boltjoint.joint.model import merge_points
from boltjoint.joint.partition import (
    choose_count,
    partition_regions,
    region_error,
    tabulate_region_errors,
)

LAWS = ("constant", "variable")


def grid(x, y):
    """Positions on all places x along the bar and y across it, one column after another."""
    return np.column_stack([np.repeat(x, len(y)), np.tile(y, len(x))]).astype(float)


# equal shares of the load


def test_regions_carry_equal_load_in_order_along_the_bar():
    joint = make_joint(pairs=2000)
    x, load = joint.position[:, 0], joint.law.slip_force
    region = bands_of_equal_load(joint.position[:, :2], load, 6)
    share = np.bincount(region, load) / load.sum()
    # a region cannot be divided finer than a pair
    np.testing.assert_allclose(share, 1 / 6, rtol=0, atol=2 * load.max() / load.sum())
    assert np.all(np.diff(region[np.argsort(x)]) >= 0)


def test_regions_do_not_depend_on_the_order_of_pairs(joint):
    position, load = joint.position[:, :2], joint.law.slip_force
    shuffled = np.random.default_rng(0).permutation(load.size)
    np.testing.assert_array_equal(
        bands_of_equal_load(position, load, 4)[shuffled],
        bands_of_equal_load(position[shuffled], load[shuffled], 4),
    )


def test_pairs_that_mirror_each_other_stay_together():
    x = np.repeat(np.arange(5.0), 4) + np.tile([0, 1e-12, -1e-12, 2e-12], 5)
    y = np.tile([-0.02, -0.01, 0.01, 0.02], 5) + np.tile([0, 1e-12], 10)
    region = bands_of_equal_load(np.column_stack([x, y]), np.ones(20), 2)
    np.testing.assert_array_equal(np.bincount(region), [10, 10])
    for i in range(5):
        of_column = region[4 * i : 4 * i + 4]
        assert of_column[0] == of_column[3]
        assert of_column[1] == of_column[2]


def test_a_pair_with_most_of_the_load_leaves_no_region_empty():
    position = np.column_stack([np.arange(8.0), np.zeros(8)])
    load = np.array([1.0, 1, 100, 1, 1, 1, 1, 1])
    for count in range(1, 9):
        region = bands_of_equal_load(position, load, count)
        np.testing.assert_array_equal(np.unique(region), np.arange(count))
        assert np.all(np.diff(region) >= 0)


def test_bands_are_divided_into_equal_loads_near_and_far_from_the_middle():
    joint = make_joint(pairs=2000)
    position, load = joint.position[:, :2], joint.law.slip_force
    region = inner_and_outer_bands(position, load, 6)
    bands = bands_of_equal_load(position, load, 3)
    np.testing.assert_array_equal(region // 2, bands)
    share = np.bincount(region, load) / load.sum()
    np.testing.assert_allclose(share, 1 / 6, rtol=0, atol=3 * load.max() / load.sum())
    from_middle = np.abs(position[:, 1])
    for inner in (0, 2, 4):
        assert from_middle[region == inner].max() <= from_middle[region == inner + 1].min()


def test_an_odd_number_is_no_inner_and_outer_bands(joint):
    with pytest.raises(ValueError, match="3 regions are not an inner and an outer one"):
        inner_and_outer_bands(joint.position[:, :2], joint.law.slip_force, 3)


# equal shares of the pressure along the middle


def test_regions_hold_equal_shares_of_the_pressure_along_the_middle():
    x, y = np.linspace(0, 1, 2001), np.array([-0.1, 0, 0.1])
    position = grid(x, y)
    pressure = 1 + position[:, 0]
    region = bands_of_equal_middle_load(position, pressure, 4)
    # from 0 to x lies x + x^2 / 2 of 3 / 2; a region begins at the first pair behind its border
    border = np.sqrt(1 + 3 * np.arange(1, 4) / 4) - 1
    begin = [position[region == i, 0].min() for i in range(1, 4)]
    np.testing.assert_array_equal(begin, x[np.searchsorted(x, border)])


def test_only_the_pressure_along_the_middle_counts():
    position = grid(np.linspace(0, 1, 21), np.array([-0.1, 0, 0.1]))
    pressure = 1 + position[:, 0]
    beside = np.where(position[:, 1] == 0, pressure, 50 * (1 - position[:, 0]))
    np.testing.assert_array_equal(
        bands_of_equal_middle_load(position, beside, 4),
        bands_of_equal_middle_load(position, pressure, 4),
    )


def test_a_region_reaches_across_the_bar():
    random = np.random.default_rng(0)
    position = grid(np.linspace(0, 1, 21), np.array([-0.1, -0.05, 0, 0.05, 0.1]))
    region = bands_of_equal_middle_load(position, random.uniform(1, 2, len(position)), 5)
    columns = region.reshape(21, 5)
    assert np.all(columns == columns[:, :1])
    assert np.all(np.diff(columns[:, 0]) >= 0)


def test_the_pressure_is_taken_straight_across_a_hole():
    # no pair of the middle between 0.4 and 0.6, where pairs beside the hole go on
    position = grid(np.linspace(0, 1, 101), np.array([-0.1, 0, 0.1]))
    hole = (position[:, 1] == 0) & (np.abs(position[:, 0] - 0.5) < 0.1 - 1e-9)
    position = position[~hole]
    pressure = np.where(position[:, 0] < 0.5, 1.0, 3.0)
    region = bands_of_equal_middle_load(position, pressure, 2)
    # from 1 at 0.4 it rises to 3 at 0.6, by 10 s: half of 0.4 + 0.4 + 1.2 is 0.4 + s + 5 s^2
    border = 0.4 + (np.sqrt(1 + 4 * 5 * 0.6) - 1) / 10
    np.testing.assert_array_equal(region, position[:, 0] > border)


def test_no_pair_on_the_centre_line_leaves_the_two_rows_next_to_it():
    y = np.array([-0.15, -0.05, 0.05, 0.15])
    position = grid(np.linspace(0, 1, 41), y)
    position[:, 1] *= 1 + 1e-12 * np.random.default_rng(0).uniform(-1, 1, len(position))
    pressure = np.where(np.abs(position[:, 1]) < 0.1, 1.0, 9.0 * position[:, 0])
    region = bands_of_equal_middle_load(position, pressure, 2)
    np.testing.assert_array_equal(region, position[:, 0] >= 0.5)


def test_mirrored_pairs_on_a_border_stay_together():
    # the border at a half is where pairs are, but for rounding
    position = grid(np.linspace(0, 1, 11), np.array([-0.1, 0, 0.1]))
    position[:, 0] += 1e-12 * np.random.default_rng(0).uniform(-1, 1, len(position))
    columns = bands_of_equal_middle_load(position, np.ones(33), 2).reshape(11, 3)
    np.testing.assert_array_equal(columns, np.repeat(np.arange(11) >= 5, 3).reshape(11, 3))


def test_regions_along_the_middle_do_not_depend_on_the_order_of_pairs():
    random = np.random.default_rng(1)
    position = grid(np.sort(random.uniform(0, 1, 40)), np.array([-0.1, 0, 0.1]))
    pressure, shuffled = random.uniform(0, 2, 120), random.permutation(120)
    np.testing.assert_array_equal(
        bands_of_equal_middle_load(position, pressure, 6)[shuffled],
        bands_of_equal_middle_load(position[shuffled], pressure[shuffled], 6),
    )


@pytest.mark.parametrize(
    ("pressure", "count"),
    [
        (np.ones(11), 12),  # more regions than places
        (np.eye(11)[5], 4),  # all pressure around one place, and borders on both sides of it
    ],
)
def test_a_region_without_a_pair_is_refused(pressure, count):
    position = np.column_stack([np.linspace(0, 1, 11), np.zeros(11)])
    with pytest.raises(ValueError, match=f"11 pairs do not divide into {count} regions"):
        bands_of_equal_middle_load(position, pressure, count)


# joints of regions


@pytest.mark.parametrize("law", LAWS)
def test_equal_load_is_the_default_and_goes_by_the_load_of_the_elements(law):
    joint = make_joint(law=law)
    regions = partition_regions(joint, make_preload(joint), 4)
    expected = bands_of_equal_load(joint.position[:, :2], joint.law.slip_force, 4)
    np.testing.assert_array_equal(regions.law.point_of_element, expected)
    assert regions.points == 4
    for rows, of_pairs in zip(regions.rows, merge_points(joint, expected).rows, strict=True):
        np.testing.assert_array_equal(rows, of_pairs)


def test_no_pressure_along_the_middle_is_refused():
    position = grid(np.linspace(0, 1, 11), np.array([-0.1, 0, 0.1]))
    with pytest.raises(ValueError, match="no pressure along the middle"):
        bands_of_equal_middle_load(position, np.abs(position[:, 1]), 2)


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


# clusters of like motion


def frozen_in_groups(law, groups=5):
    """A joint whose pairs move as one of a few points each, at random places."""
    joint = make_joint(law=law)
    group = np.random.default_rng(2).integers(0, groups, joint.points)
    normal = None if joint.normal_mode is None else joint.normal_mode[group]
    return replace(joint, tangential_mode=joint.tangential_mode[group], normal_mode=normal), group


@pytest.mark.parametrize("law", LAWS)
def test_pairs_that_move_alike_are_one_region_wherever_they_are(law):
    joint, group = frozen_in_groups(law)
    region = cluster_by_motion(joint, 5)
    # a region for each group: the pairs (region, group) that occur are as many as either
    assert len(set(zip(region, group, strict=True))) == 5
    assert np.unique(region).size == 5


@pytest.mark.parametrize("law", LAWS)
def test_every_count_up_to_that_of_the_pairs_is_met(law):
    joint, _ = frozen_in_groups(law)
    for count in (1, 4, 5, 6, 30, 60):
        np.testing.assert_array_equal(np.unique(cluster_by_motion(joint, count)), np.arange(count))


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


def test_clusters_do_not_depend_on_units_of_load_and_stiffness_alike(joint):
    # twice the frequency squared, stiffness and load: the same motion
    law = joint.law
    stiffer = replace(
        joint,
        natural_frequency=np.sqrt(2) * joint.natural_frequency,
        law=replace(
            law, tangential_stiffness=2 * law.tangential_stiffness, slip_force=2 * law.slip_force
        ),
    )
    np.testing.assert_array_equal(cluster_by_motion(stiffer, 6), cluster_by_motion(joint, 6))


@pytest.mark.parametrize("law", LAWS)
def test_cluster_by_motion_count_along_the_bar(law):
    joint = make_joint(law=law)
    region = cluster_by_motion(joint, 6)
    centre = np.bincount(region, joint.position[:, 0]) / np.bincount(region)
    assert np.all(np.diff(centre) > 0)


def test_regions_go_by_the_motion_of_the_resonances_that_count(joint):
    # contact so soft that modes stay as they are; one row varies by half, the other by quarter
    half, quarter = np.repeat([0, 1], 30), np.tile(np.repeat([0, 1], 15), 2)
    tangential = np.column_stack([1.0 + half, 50.0 * (1 + quarter), np.ones(60)])
    law = replace(joint.law, tangential_stiffness=np.full(60, 1e-6))
    joint = replace(joint, tangential_mode=tangential, law=law)
    np.testing.assert_array_equal(cluster_by_motion(joint, 2), half)
    of_two = cluster_by_motion(joint, 2, resonances=2)
    # one of the two orders in which regions may be numbered
    assert np.array_equal(of_two, quarter) or np.array_equal(of_two, 1 - quarter)


@pytest.mark.parametrize("resonances", [0, 4])
def test_resonances_that_a_joint_has_not_are_refused(joint, resonances):
    with pytest.raises(
        ValueError, match=f"resonances is {resonances}: it must be at least 1 and at most 3"
    ):
        cluster_by_motion(joint, 4, resonances=resonances)


# how regions move


@pytest.mark.parametrize("law", LAWS)
def test_load_weighted_regions_keep_the_friction_of_a_contact_that_slips_all_over(law):
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


# the error of regions, before any response


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
def test_the_error_foretells_that_of_the_peaks(joint, division):
    preload = make_preload(joint)
    forces = (0.01, 1.0, 3.0, 6.0, 10.0)  # from stuck to all slipping

    def peaks(j):
        found = [solve_branch(j, force, loss_factor=0.01) for force in forces]
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


def test_errors_are_tabulated_against_the_number_of_regions(joint):
    preload = make_preload(joint)
    table = tabulate_region_errors(joint, preload, [2, 5, 9], "clusters", "load-weighted")
    np.testing.assert_array_equal(table["count"], [2, 5, 9])
    for count, error in zip([2, 5, 9], table["region_error"].to_numpy(), strict=True):
        regions = partition_regions(joint, preload, count, "clusters", "load-weighted")
        assert error == region_error(joint, regions)
    for name in table.data_vars:
        assert {"units", "long_name"} <= set(table[name].attrs), name


@pytest.mark.parametrize("law", LAWS)
def test_the_fewest_regions_within_the_tolerance_are_chosen(law):
    joint = make_joint(law=law)
    preload = make_preload(joint)
    chosen = choose_count(joint, preload, 0.004, "clusters")
    assert 2 < chosen < 60
    errors = tabulate_region_errors(joint, preload, range(1, chosen + 1), "clusters")[
        "region_error"
    ].to_numpy()
    assert errors[-1] <= 0.004 < errors[:-1].min()


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
