"""Posterior draws where the cost has a curved valley, against the distribution in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_joint import AMPLITUDES, FAST, MODEL, PARAMETERS, TRUTH, curve_of, true_curves

import boltjoint
from boltjoint.calibration.parameters import Parameter
from boltjoint.calibration.posterior_draws import importance_draws, of_least_squares
from boltjoint.calibration.ridge import Ridge

#: scatter beside the valley
BESIDE = 0.2
BOUNDS = np.full(3, -20.0), np.full(3, 20.0)


def residual(x):
    """Along y = x², x and z are normally distributed with a deviation of 1."""
    return np.array([x[0], (x[1] - x[0] ** 2) / BESIDE, x[2]])


def cost(x):
    return 0.5 * float(residual(x) @ residual(x))


def jacobian(x):
    return np.array([[1, 0, 0], [-2 * x[0] / BESIDE, 1 / BESIDE, 0], [0, 0, 1]])


def fitted_beside(at, _):
    x = np.array([at, at**2, 0.0])
    return x, cost(x)


@pytest.fixture(scope="module")
def ridge():
    return Ridge.along(0, np.zeros(3), 0.0, (-1.96, 1.96), BOUNDS, fitted_beside, jacobian)


def test_draws_along_a_valley_have_its_mean_and_deviation(ridge):
    draws = importance_draws(cost, ridge, BOUNDS, 20_000, 1)
    assert draws.pareto_k < 0.3
    assert draws.effective > 10_000
    # those of a normal variable, and of its square
    assert draws.scaled.mean(axis=0) == pytest.approx([0, 1, 0], abs=0.05)
    assert draws.scaled.std(axis=0) == pytest.approx([1, np.sqrt(2), 1], rel=0.04)
    # which the normal approximation at the best fit misses
    covariance = np.diag([1, BESIDE**2, 1])
    normal = of_least_squares(cost, np.zeros(3), covariance, BOUNDS).draw(
        4000, np.random.default_rng(1)
    )
    assert normal[:, 1].std() < 0.3


def test_the_density_of_a_valley_is_that_of_its_draws(ridge):
    draws = ridge.draw(40_000, np.random.default_rng(2))
    density = np.exp(ridge.log_density(draws))
    # one over the density, averaged, is the volume in which draws lie; here of boxes
    for low, high in (((-0.5, -0.2, -0.5), (0.5, 0.4, 0.5)), ((0.8, 0.6, -0.5), (1.2, 1.5, 0.5))):
        inside = np.all((draws > low) & (draws < high), axis=1)
        volume = np.mean(inside / density)
        assert volume == pytest.approx(np.prod(np.subtract(high, low)), rel=0.1)
    beyond = np.array([[ridge.at[-1] + 0.1, 0.0, 0.0]])
    assert ridge.log_density(beyond) == -np.inf


def test_intervals_are_those_of_profiles_where_the_sum_of_squares_is_no_parabola():
    # far below the knee friction makes most of the damping: a loss factor is hardly told
    curves, _ = true_curves()
    curve = curve_of(curves[:8], AMPLITUDES[:8], 0.01, 0, resonance=1)
    frequency = float(MODEL.joint.natural_frequency[0])
    by_name = {parameter.name: parameter for parameter in PARAMETERS}
    parameters = [
        *(by_name[name] for name in ("tangential_stiffness", "chi", "loss_factor")),
        Parameter("natural_frequency[1]", 0.2 * frequency, 2 * frequency),
    ]
    parameters = [
        replace(parameter, start=TRUTH.get(parameter.name, frequency)) for parameter in parameters
    ]
    found = boltjoint.fit(MODEL, curve, parameters, options=FAST)
    for name in ("tangential_stiffness", "loss_factor", "natural_frequency[1]"):
        low, high = found.profile(name)
        assert low < TRUTH.get(name, frequency) < high
    low, high = np.log(found.profile("loss_factor"))
    value, error = found.scaled[2], found.standard_error[2]
    # by the covariance as far to both sides, which the damping does not allow
    assert value - low > 1.5 * (high - value)
    assert high < value + 1.5 * error
    assert tuple(found._profiles.intervals[2]) == pytest.approx((low, high))
    draws = found.draws(400)
    assert draws.pareto_k < 0.7
    drawn = np.quantile(draws.scaled[:, 0], [0.025, 0.975])
    expected = np.log(found.interval("tangential_stiffness"))
    assert np.ptp(drawn) == pytest.approx(np.ptp(expected), rel=0.35)


def test_a_best_fit_at_a_bound_has_intervals_and_draws():
    curves, amplitudes = true_curves()
    by_name = {parameter.name: parameter for parameter in PARAMETERS}
    # bounds that do not hold the value that the curve was made with
    chi = Parameter("chi", -0.95, -0.55, logarithmic=False, start=-0.6)
    parameters = [
        replace(by_name[name], start=TRUTH[name])
        for name in ("tangential_stiffness", "slip_force", "loss_factor")
    ]
    found = boltjoint.fit(
        MODEL, curve_of(curves, amplitudes, resonance=1), [*parameters, chi], options=FAST
    )
    assert found.scaled[3] == pytest.approx(-0.55, abs=1e-6)
    assert found.undetermined == ("chi",)
    assert found.reason("chi") == "the best fit lies at its bound -0.55"
    draws = found.draws(100)
    assert draws.scaled.shape == (100, 4)
    assert np.all(draws.scaled[:, 3] <= -0.55)
