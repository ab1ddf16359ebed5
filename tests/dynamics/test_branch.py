"""Errors that a branch tells of itself, and what takes the place of one that is wrong."""

import logging
from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.branch import estimate_branch_error, estimate_solution_error
from boltjoint.dynamics.response.frequency_response import (
    _in_percent,
    method_of,
    solve_branch,
    solve_response,
)
from boltjoint.dynamics.response.response_file import relative_residual, to_dataset
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl

LOSS = 0.01


@pytest.fixture(params=["constant", "variable"])
def either(request):
    """A joint of either law."""
    return make_joint(law=request.param)


def test_the_estimate_of_a_solution_off_by_little_is_its_error(either):
    branch = solve_branch(either, 5.0, damping=LOSS)
    balance = HarmonicBalance(either, LOSS, 5.0)
    x, w = branch.modal_coordinate[branch.peak], 2 * np.pi * branch.frequency[branch.peak]
    assert relative_residual(balance, x, w) < 1e-8
    assert estimate_solution_error(balance, x, w) < 1e-8
    # all amplitudes too large by a ten-thousandth: so is that of the output point
    assert estimate_solution_error(balance, (1 + 1e-4) * x, w) == pytest.approx(1e-4, rel=2e-3)
    left = balance.residual((1 + 1e-4) * x, w)
    over_force = np.linalg.norm(left) / np.linalg.norm(balance.modal_force)
    assert relative_residual(balance, (1 + 1e-4) * x, w) == pytest.approx(over_force, rel=1e-12)


def test_errors_of_one_mode_are_estimated_to_first_order(either):
    """Against the solution in all linear modes at the same frequency."""
    force = 5.0
    branch = solve_branch(either, force, method="rdnm-1", damping=LOSS)
    found = estimate_branch_error(either, branch, LOSS)
    balance = HarmonicBalance(either, LOSS, force)
    equations, checked = BalanceEquations(balance), 0
    for i in range(0, branch.frequency.size, 10):
        x, w = branch.modal_coordinate[i], 2 * np.pi * branch.frequency[i]
        solution, _ = newton(equations, x, w, StepControl())
        change = solution.x - x
        moved = change.reshape(len(balance.components), -1)[-2:] @ either.response_mode
        error = np.hypot(*moved) / branch.amplitude[i]
        if solution.converged and error < 0.05:
            assert found.of_solutions[i] == pytest.approx(error, rel=0.5, abs=1e-6)
            checked += 1
    assert checked > 5
    assert found.of_peak == found.of_solutions[branch.peak]
    largest = np.max(found.of_solutions * branch.amplitude) / branch.amplitude[branch.peak]
    assert found.largest == pytest.approx(largest)


def test_a_wrong_peak_is_reported_and_replaced_where_the_user_says_so(caplog):
    joint = make_joint(law="variable")
    with caplog.at_level(logging.WARNING):
        wrong = solve_response(joint, [0.01, 20.0], "rdnm-1", damping=LOSS)
    (warning,) = caplog.messages
    assert warning.startswith("20 N: the balance in all linear modes does not hold")
    assert wrong["peak_error_estimate"][1] > 0.05 > wrong["peak_error_estimate"][0]
    np.testing.assert_array_equal(wrong["wrong"], [0, 1])
    assert not wrong["fell_back"].any()

    linear = solve_response(joint, [0.01, 20.0], damping=LOSS)
    replaced = method_of("rdnm-1", fallback="linear")
    found = solve_response(joint, [0.01, 20.0], replaced, damping=LOSS)
    np.testing.assert_array_equal(found["fell_back"], [0, 1])
    for name in ("peak_frequency", "peak_amplitude"):
        assert found[name][1] == linear[name][1]
        assert found[name][0] == wrong[name][0] != linear[name][0]
    assert found["peak_error_estimate"][1] < 1e-6
    assert found.attrs["fallback"] == "linear"

    caplog.clear()
    solve_response(joint, [20.0], method_of("rdnm-1", largest_error=1e6), damping=LOSS)
    assert not caplog.messages


def test_a_branch_that_breaks_off_is_replaced_too(either):
    options = {"damping": LOSS, "control": StepControl(maximum_solutions=700)}
    rdnm, replaced = (
        method_of("rdnm-1", basis_update="lagged", fallback=name) for name in ("none", "linear")
    )
    alone = solve_response(either, [80.0], rdnm, **options)
    found = solve_response(either, [80.0], replaced, **options)
    assert found["complete"].all()
    assert bool(found["fell_back"][0]) == (
        not alone["complete"][0]
        or alone["peak_error_estimate"][0] > 0.05
        or alone["largest_error_estimate"][0] > 0.5
    )


def test_a_wrong_branch_without_a_peak_is_reported_too(caplog):
    joint = make_joint(law="variable")
    whole = solve_branch(joint, 20.0, method="rdnm-1", damping=LOSS)
    peak = whole.frequency[whole.peak]
    options = {"damping": LOSS, "resonance": Resonance(1, (1.02 * peak, 1.3 * peak))}
    branch = solve_branch(joint, 20.0, "rdnm-1", **options)
    assert branch.complete
    assert branch.peak is None
    error = estimate_branch_error(joint, branch, LOSS)
    assert np.isnan(error.of_peak)
    over_largest = np.max(error.of_solutions * branch.amplitude) / branch.amplitude.max()
    assert error.largest > 0
    assert error.largest == pytest.approx(over_largest)
    bound = error.largest / 20
    with caplog.at_level(logging.WARNING):
        method = method_of("rdnm-1", largest_error=bound, fallback="linear")
        found = solve_response(joint, [20.0], method, **options)
    assert "of its largest" in caplog.text
    assert [_in_percent(share) for share in (0.00123, 0.62, 1.94, 2.5e4)] == [
        "0.12 %",
        "62 %",
        "190 %",
        "2500000 %",
    ]
    assert found["fell_back"].all()
    assert not found["wrong"].any()


def test_linear_modes_have_neither_residual_nor_estimated_errors(either):
    found = solve_response(either, [0.5, 20.0], damping=LOSS)
    assert found["residual"].max() < 1e-8
    assert not found["error_estimate"].any()
    assert found["in_all_modes"].all()


def test_the_peak_of_a_branch_is_that_of_its_index(either):
    branch = solve_branch(either, 5.0, damping=LOSS)
    assert branch.peak_frequency == branch.frequency[branch.peak]
    assert branch.peak_amplitude == branch.amplitude[branch.peak]


def test_a_branch_without_a_peak_says_so_where_it_is_asked_for_it(either):
    """An index of None would give all solutions in their place."""
    low = 0.5 * min(frequency_window(either))
    branch = solve_branch(either, 5.0, damping=LOSS, resonance=Resonance(1, (low / 2, low)))
    assert branch.peak is None
    for name in ("peak_frequency", "peak_amplitude"):
        with pytest.raises(ValueError, match="the response to 5 N has no peak"):
            getattr(branch, name)


@pytest.mark.parametrize("coordinates", ["linear", "rdnm-1", "complex-rdnm-1", "backbone"])
def test_a_complete_branch_without_a_peak_says_so(coordinates):
    # beyond the resonance, which lies below 170 Hz, and far below the next one
    found = solve_response(
        make_joint(),
        [1.0],
        method=coordinates,
        damping=LOSS,
        resonance=Resonance(1, (200.0, 210.0)),
    )
    assert found["complete"].all() and np.isnan(found["peak_amplitude"]).all()
    assert found["reason"].item() == "no peak in the window"
    whole = solve_response(make_joint(), [1.0], method=coordinates, damping=LOSS)
    assert whole["reason"].item() == ""


def test_no_motion_has_no_energy_error():
    branch = solve_branch(make_joint(), 1.0, damping=LOSS)
    still = replace(branch, modal_coordinate=0 * branch.modal_coordinate)
    assert not to_dataset(make_joint(), [still], LOSS)["energy_error"].any()


def test_a_branch_is_told_in_a_line():
    branch = solve_branch(make_joint(), 5.0, damping=0.01)
    peak = f"peak {branch.peak_amplitude:.4g} m at {branch.peak_frequency:.4f} Hz"
    assert f"at a force of 5: {peak}, complete>" in repr(branch)
    broken = replace(branch, complete=False, reason="the branch would turn back")
    assert "not complete: the branch would turn back>" in repr(broken)
