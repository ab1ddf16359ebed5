"""Friction beside a viscoelastic layer, against closed forms, samples and integration in time."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import connect_small

from boltjoint.damping import ModalDamping
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import energy_per_period
from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.dynamics.response.stability import largest_multiplier
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.kelvin_voigt import KelvinVoigtLayer
from boltjoint.joint.derived import rescale_contact
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.joint.model import Joint
from boltjoint.joint.reductions import reduce_joint
from boltjoint.verification.multi_harmonic import solve_periodic
from boltjoint.verification.time_integration import steady_state

KEYS = {
    "tangential_stiffness": 5e6,
    "friction_coefficient": 0.1,
    "layer_stiffness": 2e6,
    "layer_damping": 800.0,
}
LOSS_FACTOR = 0.002


def many(seed=0, elements=40, points=6):
    """Elements on few points, and motions of these of which some slip."""
    random = np.random.default_rng(seed)
    law = KelvinVoigtLayer(
        random.integers(0, points, elements),
        random.uniform(1e6, 1e7, elements),
        random.uniform(0.5, 5.0, elements),
        random.uniform(1e5, 1e6, elements),
        random.uniform(10.0, 100.0, elements),
    )
    return law, random.normal(scale=5e-7, size=(points, 2))


def layer_joint():
    return connect_small("kelvin-voigt", KEYS)[0]


def test_force_is_that_of_friction_and_of_spring_and_dashpot():
    law, motion = many()
    frequency = 80.0
    alone = ConstantLoad(law.point_of_element, law.tangential_stiffness, law.slip_force)
    on = law.point_of_element
    spring, dashpot = (np.bincount(on, v) for v in (law.layer_stiffness, law.layer_damping))
    complex_layer = spring + 2j * np.pi * frequency * dashpot
    layer = complex_layer * (motion[:, 0] + 1j * motion[:, 1])
    expected = alone.force(motion) + np.column_stack([layer.real, layer.imag])
    np.testing.assert_allclose(law.force(motion, frequency), expected, rtol=1e-13)
    # at rest of the frequency no viscous force acts
    static = alone.force(motion) + spring[:, None] * motion
    np.testing.assert_allclose(law.force(motion), static, rtol=1e-13)
    assert np.unique(law.contact_state(motion, frequency)).size == 2
    np.testing.assert_array_equal(law.contact_state(motion), alone.contact_state(motion))


@pytest.mark.parametrize("harmonics", [0, 5])
def test_tangent_and_derivative_by_the_frequency_are_those_of_differences(harmonics):
    law, motion = many(1)
    if harmonics:
        law = AlternatingFrequencyTime(law, harmonics, samples=128)
        random = np.random.default_rng(2)
        motion = random.normal(scale=5e-7, size=(6, len(law.components)))
    w, change = 500.0, np.random.default_rng(3).normal(scale=1e-12, size=motion.shape)
    force, tangent = law.evaluate_with_tangent(motion, w)
    np.testing.assert_array_equal(force, law.evaluate(motion, w))
    difference = law.evaluate(motion + change, w) - law.evaluate(motion - change, w)
    along = 2 * np.einsum("pij,pj->pi", tangent, change)
    np.testing.assert_allclose(along, difference, atol=1e-4 * abs(difference).max())
    by_w = (law.evaluate(motion, w + 1) - law.evaluate(motion, w - 1)) / 2
    of_law = law.frequency_derivative(motion, w)
    np.testing.assert_allclose(of_law, by_w, atol=1e-10 * abs(force).max())


def test_samples_and_time_tend_to_the_closed_form():
    law, motion = many(4)
    exact, frequency = law.force(motion, 90.0), 90.0
    by_samples = [
        AlternatingFrequencyTime(law, samples=count).force(motion, frequency)
        for count in (64, 4096)
    ]
    in_time = np.column_stack([np.zeros(6), motion, np.zeros((6, 3))])
    by_time = [law.forces_in_time(in_time, count, frequency)[:, 1:3] for count in (64, 4096)]
    for coarse, fine in (by_samples, by_time):
        errors = [np.linalg.norm(found - exact) / np.linalg.norm(exact) for found in (coarse, fine)]
        assert errors[1] < 2e-6
        # of second order, but where a slider stops depends on the samples
        assert errors[0] / errors[1] > 200


def test_in_modes_forces_tangents_and_delay_are_those_of_points():
    law, _ = many(5)
    sampled = AlternatingFrequencyTime(law, 3, samples=64)
    random, w = np.random.default_rng(6), 700.0
    rows = (random.normal(size=(6, 2)),)
    amplitude = random.normal(scale=3e-7, size=(len(sampled.components), 2))
    motion = rows[0] @ amplitude.T
    at_points, tangent = sampled.evaluate_with_tangent(motion, w)
    force, of_modes = sampled.modal_force_and_tangent(rows, amplitude, w)
    np.testing.assert_allclose(force, at_points.T @ rows[0], rtol=1e-11)
    projected = np.einsum("pr,pij,ps->irjs", rows[0], tangent, rows[0])
    np.testing.assert_allclose(of_modes(), projected, rtol=0, atol=1e-11 * abs(projected).max())
    single = of_modes(np.float32)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, projected, rtol=0, atol=1e-5 * abs(projected).max())
    change = random.normal(size=amplitude.shape)
    along = np.einsum("irjs,js->ir", projected, change)
    np.testing.assert_allclose(of_modes.along(change), along, rtol=0, atol=1e-10 * abs(along).max())
    # a change that grows at the rate r has the viscous force r d beside that of its oscillation
    of_sliders = AlternatingFrequencyTime(
        ConstantLoad(law.point_of_element, law.tangential_stiffness, law.slip_force), 3, samples=64
    )
    own = sampled.modal_slider_delay(rows, amplitude, w)
    own = own - of_sliders.modal_slider_delay(rows, amplitude, w)
    d = np.bincount(law.point_of_element, law.layer_damping)
    expected = w / (2 * np.pi) * rows[0].T @ (d[:, None] * rows[0])
    for i in range(len(sampled.components)):
        np.testing.assert_allclose(own[i, :, i], expected, rtol=1e-9)


@pytest.mark.parametrize("is_sampled", [False, True])
def test_jacobians_of_balance_and_nonlinear_mode_are_those_of_differences(is_sampled):
    joint = layer_joint()
    if is_sampled:
        joint = replace(joint, law=AlternatingFrequencyTime(joint.law, 3, samples=64))
    balance = HarmonicBalance(joint, LOSS_FACTOR, 20.0)
    x = balance.stuck_solution(2 * np.pi * 71.0)
    x = x + 1e-2 * np.linalg.norm(x) * np.random.default_rng(0).normal(size=x.size)
    w, h = 2 * np.pi * 71.0, 1e-4
    difference = (balance.residual(x, w + h) - balance.residual(x, w - h)) / (2 * h)
    by_frequency = balance.frequency_derivative(x, w)
    np.testing.assert_allclose(by_frequency, difference, atol=1e-7 * abs(difference).max())
    equations = EPMCEquations(joint, LOSS_FACTOR)
    y, p = equations.damped_start(), np.log(3e-5)
    y[:-2] += 1e-2 * np.random.default_rng(1).normal(size=y.size - 2)
    jacobian = equations.evaluate(y, p)[1]()
    for j in range(y.size):
        step = np.zeros(y.size)
        step[j] = 1e-7
        column = equations.evaluate(y + step, p)[0] - equations.evaluate(y - step, p)[0]
        largest = abs(jacobian).max()
        np.testing.assert_allclose(jacobian[:, j], column / 2e-7, rtol=0, atol=2e-6 * largest)


def test_a_layer_that_never_slips_is_a_damped_spring():
    joint, frequency, force = layer_joint(), 70.0, 1.0
    strong = replace(joint, law=replace(joint.law, slip_force=1e6 * joint.law.slip_force))
    branch = solve_branch(strong, force, damping=LOSS_FACTOR)
    law, B = strong.law, strong.tangential_mode
    on, w = law.point_of_element, 2 * np.pi * branch.frequency
    k = np.bincount(on, law.tangential_stiffness + law.layer_stiffness)
    d = np.bincount(on, law.layer_damping)
    L = np.diag((2 * np.pi * strong.natural_frequency) ** 2) * (1 + 1j * LOSS_FACTOR)
    exact = [
        strong.response_mode
        @ np.linalg.solve(
            L + B.T @ ((k + 1j * v * d)[:, None] * B) - v**2 * np.eye(3),
            force * strong.excitation_mode,
        )
        for v in w
    ]
    np.testing.assert_allclose(branch.amplitude, np.abs(exact), rtol=1e-6)
    assert frequency < branch.peak_frequency


@pytest.mark.parametrize("coordinates", ["linear", "rdnm-2", "complex-rdnm-2", "backbone"])
def test_responses_in_all_coordinates_agree(coordinates):
    joint, force = layer_joint(), [30.0]
    response = solve_response(joint, force, method=coordinates, damping=LOSS_FACTOR)
    whole = solve_branch(joint, force[0], damping=LOSS_FACTOR)
    assert response["complete"].item() == 1
    assert response["peak_amplitude"].item() == pytest.approx(whole.peak_amplitude, rel=5e-3)
    # and the layer matters
    law = joint.law
    dry = ConstantLoad(law.point_of_element, law.tangential_stiffness, law.slip_force)
    other = solve_branch(replace(joint, law=dry), force[0], damping=LOSS_FACTOR)
    assert abs(other.peak_amplitude / whole.peak_amplitude - 1) > 0.05


def test_energy_balances_and_motions_are_stable():
    joint = layer_joint()
    branch = solve_branch(joint, 30.0, damping=LOSS_FACTOR)
    balance = HarmonicBalance(joint, LOSS_FACTOR, 30.0)
    x, w = branch.modal_coordinate[branch.peak], 2 * np.pi * branch.peak_frequency
    supplied, structural, contact = energy_per_period(balance, x, w)
    assert supplied == pytest.approx(structural + contact, rel=1e-8)
    d = np.bincount(joint.law.point_of_element, joint.law.layer_damping)
    motion = joint.tangential_mode @ x.reshape(2, -1).T
    in_layer = np.pi * w * d @ (motion**2).sum(axis=1)
    assert 0.01 * contact < in_layer < contact
    assert largest_multiplier(balance, x, w) < 1


def test_the_multiplier_of_a_damped_spring_is_that_of_its_eigenvalue():
    joint = layer_joint()
    strong = replace(joint, law=replace(joint.law, slip_force=1e6 * joint.law.slip_force))
    damping, w = ModalDamping((0.01,)), 2 * np.pi * 60.0
    balance = HarmonicBalance(strong, damping, 1.0)
    x = balance.stuck_solution(w)
    law, B = strong.law, strong.tangential_mode
    on = law.point_of_element
    k = np.bincount(on, law.tangential_stiffness + law.layer_stiffness)
    C = damping.matrix(strong.structure()).at(w) / w
    C = C + B.T @ (np.bincount(on, law.layer_damping)[:, None] * B)
    K = np.diag((2 * np.pi * strong.natural_frequency) ** 2) + B.T @ (k[:, None] * B)
    exponents = np.linalg.eigvals(np.block([[np.zeros((3, 3)), np.eye(3)], [-K, -C]]))
    expected = np.exp(2 * np.pi / w * exponents.real.max())
    assert largest_multiplier(balance, x, w) == pytest.approx(expected, rel=2e-3)


def one_element() -> Joint:
    """A structure of two modes on one element."""
    one = np.ones(1)
    return Joint(
        natural_frequency=np.array([50.0, 210.0]),
        excitation_mode=np.array([1.0, 0.7]),
        response_mode=np.array([1.5, -0.4]),
        tangential_mode=np.array([[0.2, -0.3]]),
        position=np.zeros((1, 3)),
        law=KelvinVoigtLayer(np.array([0]), 4e5 * one, 10.0 * one, 1e5 * one, 100.0 * one),
        element_position=np.zeros((1, 3)),
    )


def test_steady_state_in_time_is_the_balance_with_many_harmonics():
    joint, damping = one_element(), ModalDamping((0.01,))
    frequency, force = 58.0, 20.0
    steady = steady_state(joint, frequency, force, damping, ramp=20, steps=1000)
    assert steady.converged
    motion = solve_periodic(joint, frequency, force, damping, harmonics=9, samples=1024)
    assert motion.converged
    balanced = motion.amplitude(joint.response_mode)
    assert abs(steady.amplitude - balanced) < 2e-4 * abs(balanced)
    without = replace(joint, law=replace(joint.law, layer_damping=np.array([1e-9])))
    other = solve_periodic(without, frequency, force, damping, harmonics=9, samples=1024)
    # it slips, and the dashpot counts
    assert abs(other.amplitude(joint.response_mode) / balanced - 1) > 0.05
    slides = abs(joint.tangential_mode[0] @ motion.in_components(("sin", "cos")).T)
    assert slides.max() * 4e5 > 10.0


def test_stored_and_rescaled_elements_are_those_of_other_keys():
    joint = layer_joint()
    again = joint_from_dataset(joint_to_dataset(joint))
    for name in joint.law.quantities:
        np.testing.assert_array_equal(again.law.quantity(name), joint.law.quantity(name))
    other = KEYS | {"layer_damping": 1600.0, "layer_stiffness": 1e6}
    changed = rescale_contact(joint, "kelvin-voigt", KEYS, other).law
    expected = connect_small("kelvin-voigt", other)[0].law
    for name in expected.quantities:
        np.testing.assert_allclose(changed.quantity(name), expected.quantity(name), rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "value"), [("layer_stiffness", 0.0), ("layer_damping", -1.0), ("slip_force", np.nan)]
)
def test_impossible_elements_are_refused(name, value):
    law, _ = many()
    with pytest.raises(ValueError, match=name):
        replace(law, **{name: np.full(law.slip_force.size, value)})


def test_a_reduction_that_does_not_know_the_law_is_refused():
    with pytest.raises(ValueError, match="kelvin-voigt"):
        reduce_joint(layer_joint(), "iwan")
