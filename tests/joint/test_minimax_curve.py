"""Minimax loading curves."""

from itertools import pairwise

import numpy as np
import pytest
from joint_examples import many_elements
from scipy.optimize import differential_evolution
from scipy.special import softmax

from boltjoint.joint.hysteresis import loading_curve, minimax_loading_curve


def curve_error(fitted_k, fitted_s, k, s):
    """Differences of the loading curves over that of the region, at all corners of both."""
    u = np.sort(np.concatenate([fitted_s / fitted_k, s / k]))
    force = loading_curve(u, k, s)
    return u, (loading_curve(u, fitted_k, fitted_s) - force) / force


@pytest.mark.parametrize("count", [2, 3])
def test_no_loading_curve_is_nearer(count):
    k, s = many_elements(15)
    *nearest, ratio = minimax_loading_curve(k, s, count)

    def error(logs):
        a, b = np.split(logs, 2)
        return np.abs(curve_error(k.sum() * softmax(a), s.sum() * softmax(b), k, s)[1]).max()

    # the first of each kind is left at zero: shares have one degree of freedom less
    free = np.delete(np.arange(2 * count), [0, count])

    def error_of_free(x):
        logs = np.zeros(2 * count)
        logs[free] = x
        return error(logs)

    found = differential_evolution(
        error_of_free, [(-6, 6)] * free.size, seed=1, tol=1e-10, maxiter=400, popsize=20
    )
    assert ratio == pytest.approx(error(np.log(np.concatenate(nearest))), rel=1e-9)
    # the search among all curves comes as close as it can, and not below
    assert ratio * (1 - 1e-9) <= found.fun <= 1.01 * ratio


def test_minimax_loading_curve_errs_as_much_above_as_below_in_turn():
    k, s = many_elements()
    fitted_k, fitted_s, ratio = minimax_loading_curve(k, s, 5)
    u, error = curve_error(fitted_k, fitted_s, k, s)
    corners = fitted_s / fitted_k
    np.testing.assert_allclose(error[np.isin(u, corners)], ratio, rtol=1e-9)
    for low, high in pairwise(corners):
        assert error[(u > low) & (u < high)].min() == pytest.approx(-ratio, rel=1e-9)


@pytest.mark.parametrize("sharpness", [8.0, np.inf])
def test_minimax_loading_curves_keep_the_totals_and_come_nearer_with_more_elements(sharpness):
    k, s = many_elements()
    ratios = []
    for count in (1, 2, 4, 7, 12):
        fitted_k, fitted_s, ratio = minimax_loading_curve(k, s, count, sharpness)
        assert fitted_k.size == count
        assert np.all(fitted_k > 0)
        assert fitted_k.sum() == pytest.approx(k.sum(), rel=1e-9)
        assert fitted_s.sum() == pytest.approx(s.sum(), rel=1e-9)
        ratios.append(ratio)
    # the error of chords falls with the square of their number
    assert np.all(np.diff(ratios) < 0)
    assert ratios[-1] < 2 * ratios[1] * (2 / 12) ** 2


def test_minimax_loading_curve_is_the_curve_with_as_many_corners_as_it_has():
    k, s = np.array([1e8, 2e8, 3e8]), np.array([5.0, 30.0, 150.0])
    fitted_k, fitted_s, ratio = minimax_loading_curve(np.repeat(k / 9, 9), np.repeat(s / 9, 9), 5)
    assert ratio == 0
    np.testing.assert_allclose(fitted_k, [1e8, 2e8, 1e8, 1e8, 1e8], rtol=1e-9)
    np.testing.assert_allclose(fitted_s, [5, 30, 50, 50, 50], rtol=1e-9)


def test_minimax_loading_curve_does_not_depend_on_units():
    k, s = many_elements()
    *one, ratio = minimax_loading_curve(k, s, 4)
    *other, same = minimax_loading_curve(1e-3 * k, 1e3 * s, 4)
    assert same == pytest.approx(ratio, rel=1e-10)
    # the corners follow from a bisection to 1e-12
    np.testing.assert_allclose(other[0], 1e-3 * one[0], rtol=1e-8)
    np.testing.assert_allclose(other[1], 1e3 * one[1], rtol=1e-8)
