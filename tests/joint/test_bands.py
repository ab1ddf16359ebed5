"""Bands of equal load."""

import numpy as np
import pytest
from joint_examples import grid
from small_joint import make_joint

from boltjoint.joint.bands import (
    bands_of_equal_load,
    bands_of_equal_middle_load,
    inner_and_outer_bands,
)


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


def test_an_odd_number_does_not_divide_into_inner_and_outer_bands(joint):
    with pytest.raises(ValueError, match="3 regions are not an inner and an outer one"):
        inner_and_outer_bands(joint.position[:, :2], joint.law.slip_force, 3)


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


def test_no_pressure_along_the_middle_is_refused():
    position = grid(np.linspace(0, 1, 11), np.array([-0.1, 0, 0.1]))
    with pytest.raises(ValueError, match="no pressure along the middle"):
        bands_of_equal_middle_load(position, np.abs(position[:, 1]), 2)
