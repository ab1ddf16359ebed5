"""Harmonic balance over the phase of the output point, in the time of that point."""

from dataclasses import replace

import error_bars
import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.balance.balance_equations import PhaseEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.phase_resonance import find_peak
from boltjoint.dynamics.response.solutions_by_phase import SolutionsByPhase
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.solvers.newton import NewtonKrylov
from boltjoint.solvers.step_control import StepControl

FORCE, LOSS, SAMPLES = 5.0, 0.01, 60
CONTROL = StepControl(tolerance=1e-9, maximum_iterations=50)


@pytest.fixture(scope="module", params=["constant", "variable"])
def near_peak(request):
    """Equations near a peak, an unknown, and a phase of a whole number of samples from the peak."""
    joint = make_joint(law=request.param)
    at_peak = motion_at_peak(solve_response(joint, [FORCE], damping=LOSS), FORCE)
    law = AlternatingFrequencyTime(joint.contact.element_law, 5, SAMPLES)
    balance = HarmonicBalance(replace(joint, law=law), LOSS, FORCE)
    equations, y, phase = PhaseEquations.near(balance, *at_peak[::-1])
    return equations, y, round(phase * SAMPLES / (2 * np.pi)) * 2 * np.pi / SAMPLES


def test_a_motion_has_its_phase_in_the_time_of_the_excitation(near_peak):
    equations, y, phase = near_peak
    solution = NewtonKrylov(equations, CONTROL).solve(y, phase)
    assert solution.converged
    motion, frequency = equations.motion(solution.x, phase)
    amplitude = motion.amplitude(equations.balance.joint.response_mode)
    assert np.angle(amplitude) == pytest.approx(phase, abs=1e-8)
    # samples are the same at a whole number of them later
    residual = equations.balance.residual(motion.modal_coordinate.ravel(), 2 * np.pi * frequency)
    assert np.linalg.norm(residual) < 1e-8 * equations.residual_scale


@pytest.mark.parametrize("begin", [0.0, 0.3])
def test_derivatives_are_those_of_the_residual(near_peak, begin):
    equations, y, phase = near_peak
    equations, y = equations.beginning_at(y, begin)
    _, derivative = equations.evaluate(y, phase)
    jacobian, random = derivative(), np.random.default_rng(2)
    for _ in range(3):
        change = random.normal(size=y.size) * np.linalg.norm(y[:-1])
        sides = [equations.evaluate(y + h * change, phase)[0] for h in (1e-7, -1e-7)]
        expected = (sides[0] - sides[1]) / 2e-7
        # changes of contact states at samples between
        size = 1e-4 * np.linalg.norm(expected)
        np.testing.assert_allclose(jacobian @ change, expected, rtol=0, atol=size)
        np.testing.assert_allclose(derivative.along(change), jacobian @ change, atol=1e-6 * size)
    sides = [equations.evaluate(y, phase + h)[0] for h in (1e-6, -1e-6)]
    by_phase = equations.parameter_derivative(y, phase)
    scale = equations.residual_scale
    np.testing.assert_allclose(by_phase, (sides[0] - sides[1]) / 2e-6, rtol=0, atol=1e-8 * scale)


def test_time_that_begins_whole_samples_later_has_the_same_residual(near_peak):
    equations, y, phase = near_peak
    later, turned = equations.beginning_at(y, 4 * 2 * np.pi / SAMPLES)
    residual, of_later = (one.evaluate(x, phase)[0] for one, x in ((equations, y), (later, turned)))
    back = equations.balance.components.turned(of_later[:-1], -4 * 2 * np.pi / SAMPLES)
    size = np.linalg.norm(residual)
    np.testing.assert_allclose(back.ravel(), residual[:-1], rtol=0, atol=1e-10 * size)


@pytest.mark.parametrize("index", [1, 3])
def test_times_of_samples_tell_what_samples_change(index):
    """Few sliders under variable load: 272 samples change amplitudes by 1e-3 and more."""
    joint, force, loss = error_bars.small_joint("variable", index, seed=3)
    frequency, motion = motion_at_peak(solve_response(joint, [force], damping=loss), force)
    few, many = (
        find_peak(joint, frequency, force, loss, motion, harmonics=17, samples=samples)
        for samples in (272, 2176)
    )
    sizes = [abs(peak.motion.amplitude(joint.response_mode)) for peak in (few, many)]
    error = abs(sizes[0] / sizes[1] - 1)
    assert 1e-4 < error <= few.sampling_error[1] < 30 * error
    assert many.sampling_error[1] < 0.3 * few.sampling_error[1]


@pytest.mark.filterwarnings("error")
def test_solutions_between_phases_are_those_of_a_parabola_through_the_nearest():
    def at(phase):
        return np.array([2.0, phase, phase**2])

    solutions = SolutionsByPhase({0.1: at(0.1)})
    np.testing.assert_array_equal(solutions.between(0.3), at(0.1))
    solutions |= {phase: at(phase) for phase in (0.4, 0.2, 9.0)}
    np.testing.assert_allclose(solutions.between(0.3), at(0.3), rtol=1e-12)
