"""Sampled forces against exact ones."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.balance import HarmonicBalance
from boltjoint.convergence import tabulate_sampling
from boltjoint.friction.sampled import SampledInTime
from boltjoint.friction.states import STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.response import solve_response

LOSS = 0.01
FORCES = [1.0, 20.0]
SAMPLES = (64, 128, 256, 512, 1024)


@pytest.fixture(scope="module", params=["constant", "variable"])
def solved(request):
    joint = make_joint(law=request.param)
    return joint, solve_response(joint, FORCES, loss_factor=LOSS)


def test_table_has_a_row_for_every_force_and_number_of_samples(solved):
    table = tabulate_sampling({"one": solved, "other": solved}, samples=(32, 64))
    assert list(table) == ["case", "law", "samples", "force_N", "error_relative"]
    rows = [(case, force, n) for case in ("one", "other") for force in FORCES for n in (32, 64)]
    assert list(zip(table["case"], table["force_N"], table["samples"], strict=True)) == rows
    assert set(table["law"]) == {solved[0].law.name}


def test_error_is_that_of_the_forces_at_the_largest_response(solved):
    joint, response = solved
    table = tabulate_sampling({"joint": solved}, samples=(64,)).set_index("force_N")
    for force in FORCES:
        at = response.isel(solution=(response["excitation_force"] == force).to_numpy())
        at = at.isel(solution=int(np.argmax(at["response_amplitude"].to_numpy())))
        q = at["modal_coordinate"].sel(component=list(joint.law.components))
        motion = HarmonicBalance(joint, LOSS, force).motion(
            q.transpose("component", ...).to_numpy()
        )
        exact = joint.law.force(motion)
        error = SampledInTime(joint.law, samples=64).force(motion) - exact
        expected = np.sqrt((error**2).sum() / (exact**2).sum())
        # differences of nearly equal forces, 1e-4 of them
        assert table["error_relative"][force] == pytest.approx(expected, rel=1e-9)


def test_error_falls_with_the_square_of_the_samples(solved):
    table = tabulate_sampling({"joint": solved}, SAMPLES)
    for _, of_force in table.groupby("force_N"):
        error = of_force["error_relative"].to_numpy()
        slope = np.polyfit(np.log(of_force["samples"]), np.log(error), 1)[0]
        # how far transitions lie from samples scatters the errors; first order would have -1
        assert slope == pytest.approx(-2, abs=0.3)
        assert (error > 0).all()
        # the corners of a slipping force are missed by a sample in 64, squared
        assert 1e-4 < error[0] < 1e-2


def test_error_of_responses_that_were_sampled_is_also_against_exact_forces(solved):
    joint, _ = solved
    sampled = replace(joint, law=SampledInTime(joint.law, 3, samples=64))
    response = solve_response(sampled, [20.0], loss_factor=LOSS)
    error = tabulate_sampling({"joint": (joint, response)}, (64, 1024))["error_relative"]
    # against those of 64 samples the first would be nothing, and the second the larger
    assert error[0] > 50 * error[1] > 0


def test_sampling_a_joint_that_sticks_errs_by_rounding_only(solved):
    joint, _ = solved
    response = solve_response(joint, [1e-4], loss_factor=LOSS)
    assert not response["contact_state"].isin([STICK_SLIP, STICK_SLIP_SEPARATION]).any()
    error = tabulate_sampling({"joint": (joint, response)}, (64,))["error_relative"].item()
    # rounding of the normal loads, of which the forces are more than 1e-4
    assert error < 1e-11
