"""Fits of a few elements to many."""

import numpy as np
import pytest
from joint_examples import many_elements

from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.fit_jenkins import fit_elements
from boltjoint.joint.hysteresis import loop_error, unloading_branch


@pytest.mark.parametrize("method", ["loops", "describing-function"])
def test_totals_hold_and_parameters_are_positive(method):
    k, s = many_elements()
    fit = fit_elements(k, s, 4, method=method)
    assert fit.tangential_stiffness.sum() == pytest.approx(k.sum(), rel=1e-12)
    assert fit.slip_force.sum() == pytest.approx(s.sum(), rel=1e-12)
    assert np.all(fit.tangential_stiffness > 0)
    assert np.all(fit.slip_force > 0)


@pytest.mark.parametrize("method", ["loops", "describing-function"])
def test_few_elements_are_found_again(method):
    k, s = np.array([1e8, 2e8, 3e8]), np.array([5.0, 30.0, 150.0])
    fit = fit_elements(np.repeat(k / 50, 50), np.repeat(s / 50, 50), 3, method=method)
    np.testing.assert_allclose(fit.tangential_stiffness, k, rtol=1e-5)
    np.testing.assert_allclose(fit.slip_force, s, rtol=1e-5)
    assert fit.cost < 1e-8 * s.sum() ** 2


def test_more_elements_fit_better():
    k, s = many_elements()
    costs = [fit_elements(k, s, count).cost for count in (1, 2, 4, 7)]
    assert np.all(np.diff(costs) < 0)


def test_more_starts_are_never_worse():
    k, s = many_elements()
    assert fit_elements(k, s, 7, starts=16).cost <= fit_elements(k, s, 7, starts=1).cost


def test_cost_is_the_squared_difference_of_both_halves_of_all_loops():
    k, s = many_elements()
    fit = fit_elements(k, s, 4)
    phase = np.linspace(0, np.pi, 64)
    half = 0.0
    for amplitude in fit.amplitude:
        u = amplitude * np.cos(phase)
        difference = unloading_branch(amplitude, u, k, s) - unloading_branch(
            amplitude, u, fit.tangential_stiffness, fit.slip_force
        )
        half += difference @ difference
    assert fit.cost == pytest.approx(2 * half, rel=1e-9)


@pytest.mark.parametrize("method", ["loops", "describing-function"])
def test_fit_does_not_depend_on_units(method):
    k, s = many_elements()
    fit, scaled = (fit_elements(k * by, s / by, 4, method=method) for by in (1, 1e-3))
    np.testing.assert_allclose(scaled.slip_force, fit.slip_force * 1e3, rtol=1e-4)
    np.testing.assert_allclose(
        scaled.tangential_stiffness, fit.tangential_stiffness * 1e-3, rtol=1e-4
    )


def test_more_elements_than_the_region_has_are_refused():
    with pytest.raises(ValueError, match="cannot fit 4 elements to the 3 of a region"):
        fit_elements(np.ones(3), np.ones(3), 4)


def test_unknown_method_is_refused():
    with pytest.raises(ValueError, match="'magic' is not known; allowed: loops, describing-fun"):
        fit_elements(np.ones(3), np.ones(3), 2, method="magic")


def test_harmonics_of_a_fit_hold_between_the_fitted_amplitudes():
    k, s = many_elements()
    fit = fit_elements(k, s, 7)
    motion = np.zeros((1, 6))
    motion[0, 1] = np.sqrt(fit.amplitude[0] * fit.amplitude[1])

    def time_integrated(stiffness, slip):
        together = ConstantLoad(np.zeros(slip.size, dtype=np.int64), stiffness, slip)
        return together.forces_in_time(motion, 2000)[0, 1:3]

    true = time_integrated(k, s)
    few = time_integrated(fit.tangential_stiffness, fit.slip_force)
    # seven corners in place of two hundred: a per cent of the force
    assert np.linalg.norm(few - true) < 0.01 * np.linalg.norm(true)


@pytest.mark.parametrize("count", [4, 7])
def test_describing_functions_fit_loops_of_all_amplitudes_better_than_three_loops_do(count):
    k, s = many_elements()
    errors = []
    for method in ("loops", "describing-function"):
        fit = fit_elements(k, s, count, method=method)
        errors.append(loop_error(k, s, fit.tangential_stiffness, fit.slip_force))
    assert errors[1].largest < errors[0].largest
    assert errors[1].rms < errors[0].rms


@pytest.mark.parametrize("method", ["loops", "describing-function"])
def test_a_fit_moves_by_no_more_than_its_elements_do(method):
    stiffness, slip_force = (each[:40] for each in many_elements())
    noise = 1e-9 * np.random.default_rng(1).uniform(-1, 1, (2, 40))
    one = fit_elements(stiffness, slip_force, 7, method=method)
    other = fit_elements(*(np.array([stiffness, slip_force]) * (1 + noise)), 7, method=method)
    # minima of describing functions are flat along some of the unknowns
    for name in ("tangential_stiffness", "slip_force"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-5)
