"""Balances of many harmonics, and motions by their harmonics."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion, motion_at_peak
from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.dynamics.response.phase_resonance import find_peak
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl
from boltjoint.verification.multi_harmonic import ViscousBalance, solve_periodic

LOSS = 0.01
FREQUENCY = 105.0


@pytest.fixture(params=["constant", "variable"])
def either(request):
    """A joint of either law."""
    return make_joint(law=request.param)


def sampled(joint, harmonics, samples=128):
    return replace(joint, law=AlternatingFrequencyTime(joint.law, harmonics, samples))


def moved(joint, harmonics):
    """A balance and amplitudes of which the higher ones are smaller."""
    balance = ViscousBalance(sampled(joint, harmonics), LOSS, 5.0)
    x = 3e-5 * np.random.default_rng(7).normal(size=balance.modal_force.size)
    return balance, x / np.repeat(1 + np.arange(len(balance.components)), 3)


def test_one_harmonic_is_the_balance_with_structural_losses(either):
    viscous, x = moved(either, 1)
    structural = HarmonicBalance(viscous.joint, LOSS, 5.0)
    w = 2 * np.pi * FREQUENCY
    found = [balance.residual_and_jacobian(x, w) for balance in (viscous, structural)]
    residuals, jacobians = zip(*found, strict=True)
    for mine, other in (residuals, [form() for form in jacobians]):
        np.testing.assert_allclose(mine, other, rtol=1e-12, atol=1e-12 * np.abs(other).max())


def test_harmonics_are_damped_by_a_viscous_force(either):
    """C = eta L / w on the velocities of a motion, by its harmonics."""
    balance, x = moved(either, 4)
    w = 2 * np.pi * FREQUENCY
    lossless = replace(balance, damping=0.0)
    found = ((balance.dynamic_stiffness(w) - lossless.dynamic_stiffness(w)) @ x).reshape(-1, 3)
    motion = PeriodicMotion(balance.components, x.reshape(-1, 3))
    spectrum = np.fft.fft(motion.in_time(64), axis=0)
    velocity = np.fft.ifft(1j * w * np.fft.fftfreq(64, 1 / 64)[:, None] * spectrum, axis=0).real
    brake = LOSS * (2 * np.pi * either.natural_frequency) ** 2 / w * velocity
    expected = PeriodicMotion(balance.components, found).in_time(64)
    np.testing.assert_allclose(brake, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("harmonics", [1, 6])
def test_jacobian_equals_central_differences(either, harmonics):
    balance, x = moved(either, harmonics)
    w = 2 * np.pi * FREQUENCY
    jacobian = balance.residual_and_jacobian(x, w)[1]()
    for j in range(x.size):
        step = np.zeros_like(x)
        # small against the step of a sample, so that few sliders change what they do
        step[j] = 1e-11
        difference = (balance.residual(x + step, w) - balance.residual(x - step, w)) / 2e-11
        np.testing.assert_allclose(jacobian[:, j], difference, atol=1e-6 * np.abs(jacobian).max())


def test_without_losses_it_is_the_balance_of_several_harmonics(either):
    several = sampled(either, 5, 256)
    found = solve_periodic(either, 95.0, 5.0, 0.0, harmonics=5, samples=256)
    balance = HarmonicBalance(several, 0.0, 5.0)
    w = 2 * np.pi * 95.0
    control = StepControl(maximum_iterations=50)
    solution, _ = newton(BalanceEquations(balance), balance.stuck_solution(w), w, control)
    assert found.converged
    assert solution.converged
    # both residuals are below 1e-9 of the force, and the joint is far from resonance
    np.testing.assert_allclose(
        found.modal_coordinate.ravel(), solution.x, atol=1e-7 * np.abs(solution.x).max()
    )


def test_missing_harmonics_fall_off(either):
    """Forces with corners have harmonics of 1 / h^2, and motions of 1 / h^4."""
    motion, amplitudes = None, []
    for harmonics in (5, 15, 45, 101):
        motion = solve_periodic(
            either, FREQUENCY, 5.0, LOSS, harmonics=harmonics, samples=1024, start=motion
        )
        assert motion.converged
        amplitudes.append(motion.amplitude(either.response_mode))
    error = np.abs(np.array(amplitudes[:-1]) - amplitudes[-1]) / abs(amplitudes[-1])
    assert error[0] > error[1] > error[2]
    assert error[2] < 1e-3


def test_a_balance_that_is_not_solved_is_none(either):
    given_up = StepControl(maximum_iterations=1)
    found = solve_periodic(either, FREQUENCY, 20.0, LOSS, harmonics=3, control=given_up)
    assert not found.converged


def test_a_motion_by_its_harmonics():
    motion = PeriodicMotion(
        ("bias", "sin", "cos", "cos2"), np.array([[1.0, 0], [3, 5], [4, 12], [0, 7]])
    )
    phase = 2 * np.pi * np.arange(8) / 8
    first = 1 + 3 * np.sin(phase) + 4 * np.cos(phase)
    second = 5 * np.sin(phase) + 12 * np.cos(phase) + 7 * np.cos(2 * phase)
    np.testing.assert_allclose(motion.in_time(8), np.column_stack([first, second]), atol=1e-14)
    assert motion.amplitude(np.array([1.0, 0])) == 3 + 4j
    assert motion.amplitude(np.array([1.0, 1])) == 8 + 16j
    np.testing.assert_array_equal(motion.in_components(("sin3", "cos2")), [[0, 0], [0, 7]])


@pytest.mark.parametrize("force", [5.0, 20.0])
def test_a_peak_with_more_harmonics_is_that_of_its_branch(either, force):
    response = solve_response(either, [force], damping=LOSS)
    frequency, start = motion_at_peak(response, force)
    assert frequency == float(response["peak_frequency"][0])
    peak = find_peak(either, frequency, force, LOSS, start, harmonics=3, samples=2048)
    whole = solve_branch(sampled(either, 3, 2048), force, damping=LOSS)
    assert whole.complete
    amplitude = abs(peak.motion.amplitude(either.response_mode))
    assert amplitude == pytest.approx(whole.peak_amplitude, rel=1e-6)
    # that of a branch is at one of its own samples' corners
    assert peak.frequency == pytest.approx(whole.peak_frequency, rel=1e-4)


def test_no_peak_is_found_where_the_amplitude_only_rises(either):
    response = solve_response(either, [0.01], damping=LOSS)
    frequency, start = motion_at_peak(response, 0.01)
    assert find_peak(either, 0.8 * frequency, 0.01, LOSS, start, harmonics=1) is None
