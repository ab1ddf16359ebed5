"""Turning points of a branch and what sweeps show of it, on curves whose folds are known."""

import numpy as np
import pytest

from boltjoint.dynamics.response.folds import find_folds


def test_a_branch_that_does_not_turn_has_no_folds():
    frequency = np.linspace(10.0, 20.0, 50)
    folds = find_folds(frequency)
    assert folds.turning_points == 0
    assert np.isnan(folds.frequency_range).all()
    assert folds.on_sweep_up.all()
    assert folds.on_sweep_down.all()


def test_turning_points_of_a_cubic_are_where_its_derivative_vanishes():
    # frequency over arc length: s^3 - s turns at s = -1/sqrt(3) and 1/sqrt(3)
    s = np.linspace(-2.0, 2.0, 4001)
    frequency = 100.0 + s**3 - s
    turns = 1 / np.sqrt(3)
    folds = find_folds(frequency)
    assert folds.turning_points == 2
    np.testing.assert_allclose(s[folds.at], [-turns, turns], atol=1e-3)
    height = 2 / 3 * turns
    assert folds.frequency_range == pytest.approx((100.0 - height, 100.0 + height), rel=1e-8)
    # a sweep up jumps at the first turn to where the branch comes by again: s = 2/sqrt(3)
    hidden_up, hidden_down = s[~folds.on_sweep_up], s[~folds.on_sweep_down]
    assert (hidden_up.min(), hidden_up.max()) == pytest.approx((-turns, 2 * turns), abs=2e-3)
    assert (hidden_down.min(), hidden_down.max()) == pytest.approx((-2 * turns, turns), abs=2e-3)
    # between the turns lies what no sweep shows
    neither = s[~folds.on_sweep_up & ~folds.on_sweep_down]
    assert (neither.min(), neither.max()) == pytest.approx((-turns, turns), abs=2e-3)


def test_solutions_at_one_frequency_are_no_fold():
    folds = find_folds(np.array([10.0, 11.0, 11.0, 11.0 - 1e-13, 12.0]))
    assert folds.turning_points == 0
    assert folds.on_sweep_up.all()
    # nor do they hide one: it turns at the last of them
    np.testing.assert_array_equal(find_folds(np.array([10.0, 11.0, 11.0, 10.5])).at, [2])


def test_a_sweep_down_begins_beyond_what_broke_off():
    frequency = np.array([1.0, 2.0, 3.0, 2.5, 2.2])
    folds = find_folds(frequency, complete=False)
    assert not folds.on_sweep_down.any()
    np.testing.assert_array_equal(folds.on_sweep_up, [1, 1, 1, 0, 0])
    assert folds.turning_points == 1


@pytest.mark.parametrize("frequency", [[], [10.0], [10.0, 11.0]])
def test_short_branches_have_no_folds(frequency):
    folds = find_folds(np.array(frequency))
    assert folds.turning_points == 0
    assert folds.on_sweep_up.shape == (len(frequency),)
