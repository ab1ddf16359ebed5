"""Time integration against closed forms, other integrations and multi-harmonic balance."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from small_joint import make_joint

from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.model import Joint
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl
from boltjoint.verification.multi_harmonic import (
    solve_periodic,
    tabulate_steady_states,
    tabulate_time_integration,
)
from boltjoint.verification.time_integration import steady_state

LOSS = 0.01
FREQUENCY = 105.0
FORCE = 5.0


@pytest.fixture(params=["constant", "variable"])
def either(request):
    """A joint of either law."""
    return make_joint(law=request.param)


def one_element(law, modes=1, **changed):
    """One element on a structure of one mode."""
    found = Joint(
        natural_frequency=np.array([50.0, 210.0])[:modes],
        excitation_mode=np.array([1.0, 0.7])[:modes],
        response_mode=np.array([1.5, -0.4])[:modes],
        tangential_mode=np.array([[0.5, -0.3]])[:, :modes],
        position=np.zeros((1, 3)),
        law=law,
        element_position=np.zeros((1, 3)),
        normal_mode=np.array([[0.3, 0.6]])[:, :modes] if law.name == "variable" else None,
    )
    return replace(found, **changed)


def constant(k=4e5, slip=20.0):
    return ConstantLoad(np.array([0]), np.array([k]), np.array([slip]))


def variable(load):
    one = np.ones(1)
    return VariableLoad(np.array([0]), 4e5 * one, 3e5 * one, load * one, 0.3 * one)


def brute_force(joint, frequency, force, loss_factor, periods, steps):
    """First harmonic of a point by Runge and Kutta, one number after another."""
    law, w = joint.law, 2 * np.pi * frequency
    L = (2 * np.pi * joint.natural_frequency) ** 2
    k, on_mode = law.tangential_stiffness[0], joint.tangential_mode[0]
    z = 0.0

    def acceleration(t, q, v):
        x = k * on_mode @ q
        pull = joint.excitation_mode * force * np.sin(w * t) - L * q - loss_factor * L / w * v
        bound = law.slip_force[0]
        if joint.normal_mode is not None:
            n0, across = law.normal_load[0], joint.normal_mode[0]
            n = max(n0 + law.normal_stiffness[0] * across @ q, 0.0)
            pull = pull - across * (n - max(n0, 0.0))
            bound = law.friction_coefficient[0] * n
        slider = min(max(z, x - bound), x + bound)
        return pull - on_mode * (x - slider), slider

    q, v, dt = np.zeros(L.size), np.zeros(L.size), 1 / frequency / steps
    total = 0.0
    for i in range(periods * steps):
        t = i * dt
        if i >= (periods - 1) * steps:
            total += 2 / steps * joint.response_mode @ q * np.exp(1j * (np.pi / 2 - w * t))
        a1, z = acceleration(t, q, v)
        a2, _ = acceleration(t + dt / 2, q + dt / 2 * v, v + dt / 2 * a1)
        a3, _ = acceleration(t + dt / 2, q + dt / 2 * v + dt**2 / 4 * a1, v + dt / 2 * a2)
        a4, _ = acceleration(t + dt, q + dt * v + dt**2 / 2 * a2, v + dt * a3)
        q = q + dt * v + dt**2 / 6 * (a1 + a2 + a3)
        v = v + dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return total


def test_what_sticks_is_a_linear_oscillator(either):
    w = 2 * np.pi * FREQUENCY
    force = 1e-4
    L = np.diag((2 * np.pi * either.natural_frequency) ** 2)
    stiffness = L * (1 + 1j * LOSS) + either.stuck_stiffness() - w**2 * np.eye(3)
    exact = either.response_mode @ np.linalg.solve(stiffness, either.excitation_mode * force)
    found = steady_state(either, FREQUENCY, force, LOSS, ramp=20, steps=1000)
    assert found.converged
    # the step was extrapolated to its fourth power; open contacts that a small motion closes are
    # none here
    assert abs(found.amplitude - exact) < 1e-6 * abs(exact)
    assert abs(found.harmonics[1] - found.amplitude) == pytest.approx(
        found.step_error * abs(found.amplitude)
    )
    assert np.abs(found.harmonics[[0, *range(2, 10)]]).max() < 1e-6 * abs(exact)


@pytest.mark.parametrize("law", [constant(), variable(60.0), variable(-5.0)])
def test_one_element_vibrates_as_by_brute_force(law):
    joint = one_element(law, 2)
    # a period leaves 0.54 of a transient
    brute = brute_force(joint, 62.0, 60.0, 0.3, periods=20, steps=400)
    found = steady_state(joint, 62.0, 60.0, 0.3)
    stuck = newton_solution(joint, 62.0, 1e-9, 0.3) / 1e-9 * 60.0
    assert found.converged
    # where they turn, sliders of the brute force are off by the square of a step
    assert abs(found.amplitude - brute) < 3e-4 * abs(brute)
    # and the element does more than a spring
    assert abs(brute - stuck) > 0.01 * abs(brute)


def newton_solution(joint, frequency, force, loss_factor):
    """First harmonic of the output point by the balance of one, exact."""
    balance = HarmonicBalance(joint, loss_factor, force)
    w = 2 * np.pi * frequency
    control = StepControl(maximum_iterations=50)
    solution, _ = newton(BalanceEquations(balance), balance.stuck_solution(w), w, control)
    assert solution.converged
    q = dict(zip(balance.components, solution.x.reshape(-1, joint.response_mode.size), strict=True))
    return complex(joint.response_mode @ q["sin"], joint.response_mode @ q["cos"])


def test_error_falls_with_the_square_of_the_step(either):
    *integrated, finest = (
        steady_state(either, FREQUENCY, FORCE, LOSS, ramp=20, steps=steps)
        for steps in (250, 500, 1000, 3000)
    )
    reference, counts = finest.amplitude, [each.steps for each in integrated]
    errors = [abs(each.harmonics[1] - reference) for each in integrated]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    # corners of the friction fall anywhere between steps
    assert order == pytest.approx(2, abs=0.4)
    for each, error in zip(integrated, errors, strict=True):
        assert each.step_error * abs(reference) == pytest.approx(error, rel=0.5)


def test_multi_harmonic_balance_agrees_with_time_integration(either):
    motion = None
    for harmonics in (1, 9, 25, 75):
        motion = solve_periodic(
            either, FREQUENCY, FORCE, LOSS, harmonics=harmonics, start=motion, samples=1024
        )
    integrated = steady_state(either, FREQUENCY, FORCE, LOSS, steps=1000)
    assert integrated.converged
    balanced = motion.amplitude(either.response_mode)
    assert abs(balanced - integrated.amplitude) < 2e-4 * abs(balanced)
    third = motion.in_components(("sin3", "cos3")) @ either.response_mode
    assert abs(complex(*third) - integrated.harmonics[3]) < 0.01 * np.hypot(*third)


def test_one_harmonic_is_enough_where_the_motion_is_harmonic():
    """Friction that is small against inertia leaves the motion of a single mode harmonic."""
    joint = one_element(constant(slip=1.0))
    one = newton_solution(joint, 60.0, 60.0, 0.1)
    integrated = steady_state(joint, 60.0, 60.0, 0.1)
    share = abs(integrated.harmonics[3] / integrated.amplitude)
    assert 1e-5 < share < 1e-3
    assert abs(one - integrated.amplitude) < share * abs(one)
    # which is not nothing: without friction the response would be another
    without = newton_solution(one_element(constant(slip=1e-9)), 60.0, 60.0, 0.1)
    assert abs(without - integrated.amplitude) > 10 * share * abs(one)


def test_the_start_does_not_matter_where_all_contacts_slip(either):
    motion = solve_periodic(either, FREQUENCY, 40.0, LOSS, harmonics=15)
    start = motion.in_time(512)
    from_motion = steady_state(either, FREQUENCY, 40.0, LOSS, start=start, steps=1000)
    from_rest = steady_state(either, FREQUENCY, 40.0, LOSS, steps=1000)
    again = steady_state(either, FREQUENCY, 40.0, LOSS, start=from_rest.motion, steps=1000)
    for each in (from_motion, again):
        assert each.converged
        assert abs(each.amplitude - from_rest.amplitude) < 1e-6 * abs(from_rest.amplitude)
    # it begins near where it ends
    assert again.periods < from_rest.periods - 100


def test_a_contact_that_never_slips_through_keeps_the_traction_of_its_start():
    joint = one_element(constant(slip=30.0))
    from_rest = steady_state(joint, 62.0, 1.0, 0.1)
    aside = steady_state(joint, 62.0, 1.0, 0.1, start=np.full((8, 1), 1e-3))
    assert aside.converged
    # mean deflections balance the mean traction
    held = (2 * np.pi * 50.0) ** 2 * abs(aside.harmonics[0]) / (1.5 * 0.5)
    assert 0.01 * 30.0 < held < 30.0
    assert abs(from_rest.harmonics[0]) < 1e-6 * abs(aside.harmonics[0])
    assert abs(aside.amplitude - from_rest.amplitude) < 1e-6 * abs(from_rest.amplitude)


def test_light_damping_needs_no_thousands_of_periods():
    joint = one_element(constant(k=1e3, slip=1e6))
    loss = 2e-4
    stiffness = (2 * np.pi * 50.0) ** 2 + 1e3 * 0.25
    resonance = np.sqrt(stiffness) / (2 * np.pi)
    exact = 1.5 * 3.0 / (1j * loss * (2 * np.pi * 50.0) ** 2)
    found = steady_state(joint, resonance, 3.0, loss, tolerance=1e-10, steps=6000)
    assert found.converged
    assert found.periods < 600
    # the frequency of the integration errs by 4e-7 with these steps, the resonance is 2e-4 wide
    assert abs(found.amplitude - exact) < 1e-5 * abs(exact)


def test_an_integration_that_does_not_converge_says_so(joint):
    found = steady_state(joint, FREQUENCY, FORCE, 1e-4, ramp=1, maximum_periods=12, tolerance=1e-12)
    assert not found.converged
    assert found.change > 1e-12
    # the ramp is one, and both integrations are given up after twelve or a little more
    assert 25 <= found.periods <= 49


def test_steps_need_not_resolve_the_highest_mode(either):
    stiff = replace(either, natural_frequency=np.array([70.0, 360.0, 5e6]))
    w, force = 2 * np.pi * FREQUENCY, 1e-4
    L = np.diag((2 * np.pi * stiff.natural_frequency) ** 2)
    stiffness = L * (1 + 1j * LOSS) + stiff.stuck_stiffness() - w**2 * np.eye(3)
    exact = stiff.response_mode @ np.linalg.solve(stiffness, stiff.excitation_mode * force)
    found = steady_state(stiff, FREQUENCY, force, LOSS, steps=250)
    assert found.converged
    assert abs(found.amplitude - exact) < 1e-4 * abs(exact)


def test_the_table_compares_at_the_largest_response(either):
    response = solve_response(either, [0.5, 20.0], damping=LOSS)
    table = tabulate_time_integration(either, response, harmonics=(1, 9, 45), steps=1000)
    assert list(table.columns) == [
        "force_N",
        "frequency_Hz",
        "harmonics",
        "amplitude_m",
        "in_time_m",
        "difference_percent",
        "from_rest_percent",
        "step_error_percent",
        "steps_per_period",
        "periods",
        "change_per_period",
        "settled",
    ]
    assert list(table["force_N"]) == [0.5] * 3 + [20.0] * 3
    assert list(table["harmonics"]) == [1, 9, 45] * 2
    assert table["settled"].all()
    first = table[table["harmonics"] == 1]
    np.testing.assert_allclose(first["frequency_Hz"], response["peak_frequency"])
    # sampled 1024 times a period
    np.testing.assert_allclose(first["amplitude_m"], response["peak_amplitude"], rtol=1e-3)
    relative = 100 * (table["amplitude_m"] / table["in_time_m"] - 1)
    np.testing.assert_allclose(table["difference_percent"], relative, rtol=1e-9)
    assert (table[table["harmonics"] == 45]["difference_percent"].abs() < 0.1).all()


def test_the_table_knows_sampled_friction_and_some_forces(joint):
    sampled = replace(joint, law=AlternatingFrequencyTime(joint.law, 3, samples=64))
    response = solve_response(sampled, [0.5, 20.0], damping=LOSS)
    table = tabulate_time_integration(sampled, response, forces=[20.0], harmonics=(3, 9), steps=500)
    plain = tabulate_time_integration(joint, response, forces=[20.0], harmonics=(3, 9), steps=500)
    pd.testing.assert_frame_equal(table, plain)
    assert list(table["force_N"]) == [20.0, 20.0]


def test_converged_peaks_agree_with_time_and_end_after_two_small_changes(either):
    response = solve_response(either, [20.0], damping=LOSS)
    table = tabulate_steady_states(either, response, forces=[20.0], harmonics=(33, 65, 97, 129))
    amplitude = table["amplitude_m"].to_numpy()
    small = abs(np.diff(amplitude) / amplitude[:-1]) < 5e-4
    # two in succession, and only at the end
    assert small[-2:].all() and not (small[:-1] & small[1:])[:-1].any()
    assert table["settled"].all()
    assert abs(table["step_error_percent"].iloc[0]) < 0.1
    assert abs(table["difference_percent"].iloc[-1]) < 0.2
