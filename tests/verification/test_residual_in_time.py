from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.frequency_response import solve_response
from boltjoint.dynamics.harmonic_balance import HarmonicBalance
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.model import merge_points
from boltjoint.verification.residual_in_time import (
    check_solutions,
    contact_forces_in_time,
    forces_in_time,
    residuals_in_time,
)

LOSS = 0.01


@pytest.fixture(params=["constant", "variable"])
def either(request):
    """A joint of either law."""
    return make_joint(law=request.param)


def random_elements(count, seed=0):
    """Elements that open, close, stick and slip, and their motion."""
    random = np.random.default_rng(seed)
    k_u, k_v = 10 ** random.uniform(6, 9, (2, count))
    load = 10 ** random.uniform(-1, 3, count)
    mu = random.uniform(0.05, 0.8, count)
    u, v = random.normal(size=(2, count, 3))
    u *= (mu * load / k_u * 10 ** random.uniform(-1, 1.5, count))[:, None]
    v *= (load / k_v * 10 ** random.uniform(-1, 0.5, count))[:, None]
    elements = np.arange(count), k_u, k_v, load * random.choice([1, 1, 1, -1], count), mu
    return elements, np.hstack([u, v])


def at_peak(response):
    at = response["response_amplitude"].to_numpy().argmax()
    return response.isel(solution=[at]).copy(deep=True)


def test_forces_in_time_converge_to_the_exact_ones_with_second_order():
    elements, motion = random_elements(1000)
    law = VariableLoad(*elements)
    exact = law.force(motion)
    load = np.abs(law.normal_load) + law.normal_stiffness * np.abs(motion[:, 3:]).sum(axis=1)
    counts = 100 * 2 ** np.arange(6)
    errors = [
        np.std((contact_forces_in_time(*elements, motion, count) - exact) / load[:, None])
        for count in counts
    ]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order == pytest.approx(2, abs=0.2)


def test_forces_in_time_and_aft_agree_to_rounding_at_the_same_samples():
    elements, motion = random_elements(300, seed=1)
    in_time = contact_forces_in_time(*elements, motion, 200)
    other = AlternatingFrequencyTime(VariableLoad(*elements), samples=200).force(motion)
    np.testing.assert_allclose(in_time, other, atol=1e-11 * np.abs(other).max())
    on, k, slip = elements[0], elements[1], elements[4] * np.abs(elements[3])
    in_time = forces_in_time(on, k, slip, motion[:, 1:3], 200)
    other = AlternatingFrequencyTime(ConstantLoad(on, k, slip), samples=200).force(motion[:, 1:3])
    np.testing.assert_allclose(in_time, other, atol=1e-11 * np.abs(other).max())


def test_a_load_that_nothing_changes_is_a_constant_one():
    elements, motion = random_elements(300, seed=2)
    on, k_u, k_v, load, mu = elements
    load = np.abs(load)
    still = motion.copy()
    still[:, [0, 3, 4, 5]] = 0.0
    in_time = contact_forces_in_time(on, k_u, k_v, load, mu, still, 200)
    constant = forces_in_time(on, k_u, mu * load, motion[:, 1:3], 200)
    np.testing.assert_allclose(in_time[:, 1:3], constant, rtol=1e-9)
    np.testing.assert_allclose(in_time[:, 3:], 0, atol=1e-12 * load.max())


def test_elements_on_one_point_add_up():
    (_, *elements), motion = random_elements(200, seed=3)
    on, motion = np.random.default_rng(4).choice([0, 2], 200), motion[:3]
    together = contact_forces_in_time(on, *elements, motion, 100)
    alone = contact_forces_in_time(np.arange(200), *elements, motion[on], 100)
    for p in range(3):
        np.testing.assert_allclose(together[p], alone[on == p].sum(axis=0), rtol=1e-9)


def test_solutions_have_no_residual_in_time(either):
    regions = merge_points(either, np.repeat([0, 1, 2, 3], 15))
    for joint in (either, regions):
        response = solve_response(joint, [0.5, 5.0, 20.0, 80.0], loss_factor=LOSS)
        assert response["complete"].all()
        assert response["converged"].all()
        some = response.isel(solution=slice(None, None, 10))
        # the error of the check is about 1 / samples^2 of the contact forces
        assert residuals_in_time(joint_to_dataset(joint), some).max() < 1e-6


def test_the_residual_in_time_is_that_of_the_balance(either):
    response = solve_response(either, [5.0], loss_factor=LOSS)
    wrong = at_peak(response)
    wrong["modal_coordinate"] *= 1 + 1e-4
    found = residuals_in_time(joint_to_dataset(either), wrong)[0]

    balance = HarmonicBalance(either, LOSS, 5.0)
    w = 2 * np.pi * float(wrong["frequency"][0])
    wanted = wrong["modal_coordinate"].sel(component=list(balance.components))
    x = wanted.transpose("solution", "component", "mode").to_numpy().ravel()
    elasticity = np.tile((2 * np.pi * either.natural_frequency) ** 2, len(balance.components)) * x
    contact = balance.residual(x, w) - balance.dynamic_stiffness(w) @ x + balance.modal_force
    inertia = balance.dynamic_stiffness(0.0) @ x - balance.dynamic_stiffness(w) @ x
    terms = (elasticity, contact, inertia, balance.modal_force)
    largest = max(np.linalg.norm(term) for term in terms)
    assert found == pytest.approx(np.linalg.norm(balance.residual(x, w)) / largest, rel=0.02)
    # on resonance elasticity and inertia cancel: damping is what is out of balance
    assert found > 3e-6


def test_a_wrong_bias_is_found():
    joint = make_joint(law="variable")
    response = solve_response(joint, [20.0], loss_factor=LOSS)
    wrong = at_peak(response)
    wrong["modal_coordinate"].loc[{"component": "bias"}] *= 1.01
    assert residuals_in_time(joint_to_dataset(joint), wrong, maximum_samples=8000) > 1e-4


def test_more_samples_are_taken_where_they_are_needed(joint):
    response = solve_response(joint, [20.0], loss_factor=LOSS)
    peak = at_peak(response)
    few = residuals_in_time(joint_to_dataset(joint), peak, samples=50, maximum_samples=100)
    enough = residuals_in_time(joint_to_dataset(joint), peak, samples=50)
    assert few > 5e-6
    assert enough < 1e-6


def test_the_check_has_a_row_for_each_force(either):
    response = solve_response(either, [0.5, 20.0], loss_factor=LOSS)
    response = response.isel(solution=slice(None, None, 20)).copy(deep=True)
    response["converged"][0] = 0
    response["modal_coordinate"][0] = 1.0
    check = check_solutions(joint_to_dataset(either), response)
    assert list(check) == ["force_N", "solutions", "residual_in_time", "frequency_Hz"]
    assert list(check["force_N"]) == [0.5, 20.0]
    assert check["solutions"].sum() == response.sizes["solution"] - 1
    for row in check.itertuples():
        mine = (response["excitation_force"] == row.force_N) & (response["converged"] == 1)
        left = residuals_in_time(
            joint_to_dataset(either), response.isel(solution=np.flatnonzero(mine))
        )
        assert row.residual_in_time == left.max()
        assert row.frequency_Hz == response["frequency"][np.flatnonzero(mine)[left.argmax()]]
    assert (check["residual_in_time"] < 1e-6).all()
    coarse = check_solutions(joint_to_dataset(either), response, samples=64000)
    assert (coarse["residual_in_time"] < check["residual_in_time"]).all()


def test_further_harmonics_are_refused(joint):
    sampled = replace(joint, law=AlternatingFrequencyTime(joint.law, 3))
    response = solve_response(sampled, [0.5], loss_factor=LOSS)
    with pytest.raises(ValueError, match="first harmonic only, not sin3, cos3"):
        residuals_in_time(joint_to_dataset(joint), response)
