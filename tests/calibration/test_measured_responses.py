"""Fits to stepped sines: against frequency responses of the joint, and central differences."""

import numpy as np
import pytest
from calibrated_joint import FAST, MODEL, PARAMETERS, TRUTH

from boltjoint import MeasuredResponse, fit, solve_branch
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.parameters import ParameterSpace
from boltjoint.calibration.response_points import solve_motions
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance

SPACE = ParameterSpace(PARAMETERS)
AT_TRUTH = SPACE.scaled(list(TRUTH.values()))


def response(force, noise=0.0, seed=0, with_phase=True, **given):
    """Every seventh solution of a branch as if it had been measured."""
    joint, damping = MODEL(TRUTH)
    branch = solve_branch(joint, force, damping=damping)
    every = slice(None, None, 7)
    frequency, amplitude = branch.frequency[every], branch.amplitude[every]
    solved = solve_motions(
        HarmonicBalance(joint, damping, 1.0),
        joint.response_mode,
        "displacement",
        frequency,
        amplitude,
    )
    random = np.random.default_rng(seed)
    scatter = noise * random.standard_normal((2, frequency.size))
    phase = solved.values[:, 1] + scatter[1]
    of_phase = {"phase": phase, "phase_deviation": noise or 0.01} if with_phase else {}
    return MeasuredResponse(
        frequency,
        amplitude,
        force * np.exp(scatter[0]),
        force * (noise or 0.01),
        **of_phase,
        name=f"{force} N",
        **given,
    )


@pytest.mark.parametrize("force", [0.1, 2.0, 8.0])
def test_the_excitation_of_a_branch_is_its_force(force):
    """From stuck to slipping, stable or not: one excitation for each frequency and amplitude."""
    joint, damping = MODEL(TRUTH)
    branch = solve_branch(joint, force, damping=damping)
    solved = solve_motions(
        HarmonicBalance(joint, damping, 1.0),
        joint.response_mode,
        "displacement",
        branch.frequency,
        branch.amplitude,
    )
    assert np.exp(solved.values[:, 0]) == pytest.approx(force, rel=1e-7)
    phase = solved.values[:, 1]
    assert -0.2 < phase[0] < 0
    assert -np.pi < phase[-1] < -2.5
    peak = np.argmax(branch.amplitude)
    assert phase[peak] == pytest.approx(-np.pi / 2, abs=0.1)


@pytest.mark.parametrize("quantity", ["displacement", "acceleration"])
def test_derivatives_are_those_of_central_differences(quantity):
    joint, damping = MODEL(TRUTH)
    branch = solve_branch(joint, 4.0, damping=damping)
    frequency, amplitude = branch.frequency[::20], branch.amplitude[::20]
    if quantity == "acceleration":
        amplitude = amplitude * (2 * np.pi * frequency) ** 2
    measured = MeasuredResponse(
        frequency, amplitude, 4.0, 0.1, np.zeros(frequency.size), 0.1, quantity=quantity
    )
    compared = ModelCurves(MODEL, (measured,), SPACE)
    _, jacobian = compared.residual_and_jacobian(AT_TRUTH)
    step = 1e-4
    for n in range(AT_TRUTH.size):
        change = step * np.eye(AT_TRUTH.size)[n]
        values = [compared.residual(AT_TRUTH + times * change) for times in (-2, -1, 1, 2)]
        difference = np.array([1, -8, 8, -1]) @ values / (12 * step)
        assert jacobian[:, n] == pytest.approx(difference, rel=1e-5, abs=1e-6 * abs(jacobian).max())


def test_phases_of_an_acceleration_are_half_a_turn_off():
    joint, damping = MODEL(TRUTH)
    balance = HarmonicBalance(joint, damping, 1.0)
    w = 2 * np.pi * np.array([90.0])
    moved, accelerated = (
        solve_motions(balance, joint.response_mode, quantity, w / (2 * np.pi), 1e-6 * factor)
        for quantity, factor in (("displacement", 1.0 + 0 * w), ("acceleration", w**2))
    )
    assert accelerated.values[0, 0] == pytest.approx(moved.values[0, 0], rel=1e-12)
    turn = accelerated.values[0, 1] - moved.values[0, 1]
    assert turn == pytest.approx(np.pi, rel=1e-12)


def test_parameters_are_found_within_their_errors():
    """Four parameters from responses at two forces, with 1 % of noise, and no backbone."""
    measured = [response(force, 0.01, seed) for seed, force in enumerate((1.0, 8.0))]
    found = fit(MODEL, measured, PARAMETERS, options=FAST)
    assert not found.undetermined
    assert not found.refusals
    off = found.scaled - AT_TRUTH
    assert np.all(abs(off) < 3 * found.standard_error)
    assert np.all(found.standard_error < [0.02, 0.01, 0.05, 0.2])
    assert [len(errors) for errors in found.rms_errors] == [2, 2]
    assert "rad rms in phase" in found.summary()


def test_amplitudes_alone_tell_parameters_too():
    measured = [response(force, 0.01, 3, with_phase=False) for force in (1.0, 8.0)]
    found = fit(MODEL, measured, PARAMETERS, options=FAST)
    low, high = found.interval("slip_force")
    assert low < TRUTH["slip_force"] < high
    assert [len(errors) for errors in found.rms_errors] == [1, 1]


def test_another_law_is_refused():
    """Responses of twice the friction are not those of the model with its parameters held."""
    joint, damping = MODEL({**TRUTH, "slip_force": 72.0})
    branch = solve_branch(joint, 8.0, damping=damping)
    measured = MeasuredResponse(branch.frequency[::7], branch.amplitude[::7], 8.0, 0.08)
    found = fit(MODEL(TRUTH)[0], measured, [PARAMETERS[3]], options=FAST)
    assert "the excitation is off by" in found.refusals[0]


def test_held_aside_responses_are_predicted():
    measured = [response(force, 0.01, seed) for seed, force in enumerate((1.0, 8.0))]
    found = fit(MODEL, measured, PARAMETERS, options=FAST)
    (predicted,) = found.predict(response(4.0, 0.01, 5), count=60)
    within = predicted.points_within
    points = predicted.measured.amplitude.size
    assert min(within) >= 0.85 * points
    assert max(predicted.rms_errors) < 0.03


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"frequency": []}, "is empty"),
        ({"amplitude": [1.0]}, "amplitude"),
        ({"excitation": [1.0, -1.0]}, "excitation"),
        ({"excitation_deviation": 0.0}, "excitation_deviation"),
        ({"phase": [0.0, 0.1]}, "phase_deviation of response is missing"),
        ({"quantity": "strain"}, "quantity"),
        ({"configuration": {"preload_N": "high"}}, "preload_N of configuration"),
    ],
)
def test_what_is_no_response_is_refused(changed, said):
    given = {
        "frequency": [100.0, 101.0],
        "amplitude": [1e-5, 2e-5],
        "excitation": [1.0, 1.0],
        "excitation_deviation": 0.01,
    }
    with pytest.raises(ValueError, match=said):
        MeasuredResponse(**(given | changed))
