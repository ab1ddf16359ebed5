from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.derived import merge_points
from boltjoint.joint.io import joint_to_dataset
from boltjoint.verification.residual_in_time import check_solutions, residuals_in_time

LOSS = 0.01


@pytest.fixture(params=["constant", "variable"])
def either(request):
    """A joint of either law."""
    return make_joint(law=request.param)


def at_peak(response):
    at = response["response_amplitude"].to_numpy().argmax()
    return response.isel(solution=[at]).copy(deep=True)


def test_solutions_have_no_residual_in_time(either):
    regions = merge_points(either, np.repeat([0, 1, 2, 3], 15))
    for joint in (either, regions):
        response = solve_response(joint, [0.5, 5.0, 20.0, 80.0], damping=LOSS)
        assert response["complete"].all()
        assert response["converged"].all()
        some = response.isel(solution=slice(None, None, 10))
        # the error of the check is about 1 / samples^2 of the contact forces
        assert residuals_in_time(joint_to_dataset(joint), some).max() < 1e-6


def test_the_residual_in_time_is_that_of_the_balance(either):
    response = solve_response(either, [5.0], damping=LOSS)
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
    response = solve_response(joint, [20.0], damping=LOSS)
    wrong = at_peak(response)
    wrong["modal_coordinate"].loc[{"component": "bias"}] *= 1.01
    assert residuals_in_time(joint_to_dataset(joint), wrong, maximum_samples=8000) > 1e-4


def test_more_samples_are_taken_where_they_are_needed(joint):
    response = solve_response(joint, [20.0], damping=LOSS)
    peak = at_peak(response)
    few = residuals_in_time(joint_to_dataset(joint), peak, samples=50, maximum_samples=100)
    enough = residuals_in_time(joint_to_dataset(joint), peak, samples=50)
    assert few > 5e-6
    assert enough < 1e-6


def test_the_check_has_a_row_for_each_force(either):
    response = solve_response(either, [0.5, 20.0], damping=LOSS)
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
    response = solve_response(sampled, [0.5], damping=LOSS)
    with pytest.raises(ValueError, match="first harmonic only, not sin3, cos3"):
        residuals_in_time(joint_to_dataset(joint), response)
