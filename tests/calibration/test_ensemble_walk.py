"""Walkers of a posterior, against its closed form and against importance draws."""

import sys
from functools import cache

import numpy as np
import pytest
from calibrated_joint import FAST, MODEL, PARAMETERS, curve_of, synthetic, true_curves

import boltjoint
from boltjoint.calibration.ensemble_walk import ensemble_draws

BOUNDS = np.full(3, -20.0), np.full(3, 20.0)


def cost(x):
    """Along y = x², x and z are normally distributed with a deviation of 1."""
    return 0.5 * (x[0] ** 2 + ((x[1] - x[0] ** 2) / 0.5) ** 2 + x[2] ** 2)


def test_walkers_have_the_moments_of_a_curved_valley():
    draws = ensemble_draws(cost, np.zeros(3), np.full(3, 0.5), BOUNDS, 60_000, 1)
    assert draws.scaled.shape == (60_000, 3)
    assert draws.effective > 500
    assert 0.2 < draws.accepted < 0.7
    assert draws.scaled.mean(axis=0) == pytest.approx([0, 1, 0], abs=0.15)
    assert draws.scaled.std(axis=0) == pytest.approx([1, 1.5, 1], rel=0.1)
    again = ensemble_draws(cost, np.zeros(3), np.full(3, 0.5), BOUNDS, 60_000, 1)
    np.testing.assert_array_equal(again.scaled, draws.scaled)


def test_bounds_hold_and_a_model_without_a_mode_has_no_draws():
    def half(x):
        if x[0] < 0.5:
            raise ValueError("no mode")
        return cost(x)

    low = np.array([-20.0, -20.0, 0.3])
    bounds = low, BOUNDS[1]
    draws = ensemble_draws(half, np.array([0.6, 0.4, 0.5]), np.ones(3), bounds, 4000, 2)
    assert draws.scaled[:, 0].min() >= 0.5
    assert draws.scaled[:, 2].min() >= 0.3


@cache
def found():
    curves, amplitudes = true_curves()
    few = curve_of(curves[::3], amplitudes[::3], 0.01, 1)
    return boltjoint.fit(MODEL, few, PARAMETERS, options=FAST)


def test_walkers_and_importance_draws_agree():
    walked, drawn = found().walk(3000), found().draws(2000)
    assert walked.effective > 60
    assert walked.scaled.std(axis=0) == pytest.approx(drawn.scaled.std(axis=0), rel=0.3)
    off = abs(walked.scaled.mean(axis=0) - drawn.scaled.mean(axis=0))
    assert np.all(off < 0.4 * drawn.scaled.std(axis=0))


def test_draws_of_walkers_make_bands():
    held = synthetic(5, resonance=2)
    (by_walkers,) = found().predict(held, drawn=found().walk(400).scaled)
    assert len(by_walkers.draws) == 400
    assert min(by_walkers.points_within) >= 16
    with pytest.raises(ValueError, match="drawn has shape"):
        found().predict(held, drawn=np.ones((3, 2)))


def test_without_emcee_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(ValueError, match=r"pip install boltjoint\[mcmc\]"):
        found().walk(400)
