"""Responses on one grid of frequencies."""

import numpy as np
import pytest

from boltjoint.study.common_to_designs import amplitude_on_grid


def resonance(frequency):
    return 1 / np.hypot(1 - (frequency / 80) ** 2, 0.01)


def test_a_response_between_its_solutions():
    frequency = np.sort(np.concatenate([np.linspace(60, 100, 60), 80 + np.linspace(-2, 2, 80)]))
    grid = np.linspace(60, 100, 357)
    found = amplitude_on_grid(frequency, resonance(frequency), grid)
    np.testing.assert_allclose(found, resonance(grid), rtol=2e-3)


def test_of_several_solutions_the_largest_counts():
    # a path that turns back at 90 Hz and again at 70 Hz
    frequency = np.concatenate([np.linspace(60, 90, 40), np.linspace(90, 70, 40)[1:]])
    frequency = np.concatenate([frequency, np.linspace(70, 100, 40)[1:]])
    amplitude = np.concatenate([np.full(40, 3.0), np.full(39, 2.0), np.full(39, 1.0)])
    grid = np.array([65.0, 75.0, 85.0, 95.0])
    np.testing.assert_allclose(amplitude_on_grid(frequency, amplitude, grid), [3, 3, 3, 1])


def test_beyond_the_path_there_is_nothing():
    found = amplitude_on_grid(
        np.array([70.0, 80.0]), np.array([1.0, 2.0]), np.arange(60.0, 100, 10)
    )
    np.testing.assert_array_equal(found, [np.nan, 1.0, 2.0, np.nan])


def test_a_solution_alone_is_no_response():
    assert np.isnan(amplitude_on_grid(np.array([70.0]), np.array([1.0]), np.array([70.0]))).all()


def test_a_grid_ascends():
    with pytest.raises(ValueError, match="grid must ascend"):
        amplitude_on_grid(np.array([1.0, 2.0]), np.array([1.0, 2.0]), np.array([2.0, 1.0]))
