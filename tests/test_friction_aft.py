"""AFT against analytic describing functions and fine time integration."""

from dataclasses import replace

import numpy as np
import pytest

from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.variable import VariableLoad


def constant_load(count, harmonics=1, seed=0):
    """Elements from deep in stick to deep in slip, and their motion."""
    random = np.random.default_rng(seed)
    k = 10 ** random.uniform(6, 9, count)
    slip = 10 ** random.uniform(-1, 3, count)
    law = ConstantLoad(np.arange(count), k, slip)
    size = slip / k * 10 ** random.uniform(-1, 2, count)
    odd = (harmonics + 1) // 2
    return law, size[:, None] * random.normal(size=(count, 2 * odd))


def variable_load(count, harmonics=1, seed=0):
    """Elements in every state of contact, some with a gap, and their motion."""
    random = np.random.default_rng(seed)
    k_u, k_v = 10 ** random.uniform(6, 9, (2, count))
    load = 10 ** random.uniform(-1, 3, count)
    mu = random.uniform(0.05, 0.8, count)
    sign = random.choice([1, 1, 1, -1], count)
    law = VariableLoad(np.arange(count), k_u, k_v, sign * load, mu)
    components = 1 + 2 * harmonics
    u, v = random.normal(size=(2, count, components))
    u *= (mu * load / k_u * 10 ** random.uniform(-1, 1.5, count))[:, None]
    v *= (load / k_v * 10 ** random.uniform(-1, 0.5, count))[:, None]
    return law, np.hstack([u, v])


def iwan(count, harmonics=1, seed=0):
    """Iwan elements from deep in microslip to deep in macroslip, and their motion."""
    law, motion = constant_load(count, harmonics, seed)
    random = np.random.default_rng(seed)
    shapes = random.uniform(-0.95, 0.0, count), random.choice([0.0, 0.1, 3.0], count)
    springs = law.point_of_element, law.tangential_stiffness, law.slip_force
    return FourParameterIwan(*springs, *shapes), motion


def limit(law, motion):
    """The largest friction force and normal load of elements on one point each."""
    if not isinstance(law, VariableLoad):
        return law.slip_force[:, None]
    v = np.abs(motion[:, motion.shape[1] // 2 :]).sum(axis=1)
    load = np.abs(law.normal_load) + law.normal_stiffness * v
    return np.repeat(
        np.column_stack([law.friction_coefficient * load, load]), motion.shape[1] // 2, axis=1
    )


def sampled_component(name, phase):
    if name == "bias":
        return np.ones_like(phase)
    return {"sin": np.sin, "cos": np.cos}[name[:3]](int(name[3:] or 1) * phase)


def integrate_finely(law, components, motion, samples):
    """Forces by time integration without interpolation between samples."""
    phase = 2 * np.pi * np.arange(samples) / samples
    at = np.array([sampled_component(name, phase) for name in components])
    u = motion[:, : len(at)] @ at
    if isinstance(law, ConstantLoad):
        bound, n = np.broadcast_to(law.slip_force[:, None], u.shape), None
    else:
        v = motion[:, len(at) :] @ at
        n = np.maximum(law.normal_load[:, None] + law.normal_stiffness[:, None] * v, 0)
        bound = law.friction_coefficient[:, None] * n
    x = law.tangential_stiffness[:, None] * u
    lower, upper, f = x - bound, x + bound, np.empty_like(x)
    slider = np.zeros(len(u))
    for i in [*range(samples), *range(samples)]:
        slider = np.minimum(np.maximum(slider, lower[:, i]), upper[:, i])
        f[:, i] = x[:, i] - slider
    forces = [f] if n is None else [f, n - np.maximum(law.normal_load, 0)[:, None]]
    weight = np.array([1 if name == "bias" else 2 for name in components]) / samples
    return np.hstack([each @ at.T * weight for each in forces])


both_laws = pytest.mark.parametrize("population", [constant_load, variable_load])
all_laws = pytest.mark.parametrize("population", [constant_load, variable_load, iwan])


@all_laws
def test_forces_converge_to_the_analytic_ones_with_second_order(population):
    law, motion = population(2000)
    exact, largest = law.force(motion), limit(law, motion)
    counts = 2 ** np.arange(6, 11)
    errors = [
        np.std((AlternatingFrequencyTime(law, samples=int(count)).force(motion) - exact) / largest)
        for count in counts
    ]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order == pytest.approx(2, abs=0.2)
    assert errors[2] < 1e-3


@both_laws
def test_states_are_those_of_the_analytic_law(population):
    law, motion = population(2000)
    states = law.contact_state(motion)
    assert set(states) == ({0, 1} if population is constant_load else {0, 1, 2, 3})
    # none of the random elements is within a sample of its limit
    np.testing.assert_array_equal(
        AlternatingFrequencyTime(law, samples=1024).contact_state(motion), states
    )


@both_laws
@pytest.mark.parametrize("harmonics", [1, 3, 5])
def test_forces_equal_fine_time_integration(population, harmonics):
    law, motion = population(60, harmonics, seed=1)
    aft = AlternatingFrequencyTime(law, harmonics, samples=2048)
    fine = integrate_finely(law, aft.components, motion, 16384)
    error = (aft.force(motion) - fine) / limit(law, motion)
    # without interpolation a contact closes up to a sample late
    assert np.abs(error).max() < 1e-3


@all_laws
@pytest.mark.parametrize("harmonics", [1, 4])
def test_tangent_equals_central_differences(population, harmonics):
    law, motion = population(300, harmonics, seed=2)
    aft = AlternatingFrequencyTime(law, harmonics, samples=64)
    force, tangent = aft.force_and_tangent(motion)
    np.testing.assert_array_equal(force, aft.force(motion))
    stiffness = np.maximum(law.tangential_stiffness, getattr(law, "normal_stiffness", 0))
    for j in range(motion.shape[1]):
        step = np.zeros_like(motion)
        step[:, j] = 1e-7 * np.abs(motion).max(axis=1)
        difference = (aft.force(motion + step) - aft.force(motion - step)) / (2 * step[:, j, None])
        error = np.abs(tangent[:, :, j] - difference).max(axis=1) / stiffness
        assert error.max() < 1e-6


@all_laws
@pytest.mark.parametrize("harmonics", [1, 5])
@pytest.mark.parametrize(("elements", "modes"), [(200, 3), (20, 32)])  # more, and fewer
def test_modal_forces_are_projections_of_those_of_the_points(
    population, elements, modes, harmonics
):
    law, _ = population(elements)
    random = np.random.default_rng(6)
    law = replace(law, point_of_element=random.integers(0, 80, elements))
    aft = AlternatingFrequencyTime(law, harmonics, samples=64)
    rows = [random.normal(size=(80, modes)) for _ in law.directions]
    amplitude = 3e-6 * random.normal(size=(len(aft.components), modes))
    motion = np.hstack([B @ amplitude.T for B in rows])
    # some of an Iwan element always slips
    assert len(set(aft.contact_state(motion))) > (population is not iwan)
    force, tangent = aft.force_and_tangent(motion)
    count = len(aft.components)
    force = force.reshape(80, -1, count)
    tangent = tangent.reshape(80, len(rows), count, len(rows), count)
    expected = np.einsum("dpr,pdi->ir", rows, force)
    expected_tangent = np.einsum("dpr,pdiej,eps->irjs", rows, tangent, rows)
    found, found_tangent = aft.modal_force_and_tangent(tuple(rows), amplitude, 0.0)
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(
        found_tangent(), expected_tangent, atol=1e-12 * np.abs(expected_tangent).max()
    )
    single = found_tangent(np.float32)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, expected_tangent, atol=1e-5 * np.abs(expected_tangent).max())
    change = random.normal(size=amplitude.shape)
    expected_change = np.einsum("irjs,js", expected_tangent, change)
    np.testing.assert_allclose(
        found_tangent.along(change), expected_change, atol=1e-12 * np.abs(expected_change).max()
    )


@all_laws
def test_a_shift_by_a_sample_turns_the_force_along(population):
    law, motion = population(50, 3, seed=3)
    aft = AlternatingFrequencyTime(law, 3, samples=100)
    turn = np.zeros((len(aft.components),) * 2)
    for i, name in enumerate(aft.components):
        if name.startswith("sin"):
            angle = int(name[3:] or 1) * 2 * np.pi / 100
            c, s = np.cos(angle), np.sin(angle)
            turn[i : i + 2, i : i + 2] = [[c, -s], [s, c]]
    turn[0, 0] = 1.0 if "bias" in aft.components else turn[0, 0]
    turn = np.kron(np.eye(len(law.directions)), turn)
    error = aft.force(motion @ turn.T) - aft.force(motion) @ turn.T
    np.testing.assert_allclose(error / limit(law, motion), 0, atol=1e-12)


@all_laws
def test_elements_on_one_point_add_up_in_any_order(population):
    law, motion = population(40, 3, seed=4)
    motion = motion[[0, 7, 5]]
    on = np.random.default_rng(5).choice([0, 2], 40)

    def some(elements):
        quantities = {name: getattr(law, name)[elements] for name in law.quantities}
        return AlternatingFrequencyTime(type(law)(on[elements], **quantities), 3)

    every = np.arange(40)
    alone = sum(some([e]).force(motion) for e in every)
    np.testing.assert_array_equal(alone[1], 0)
    for order in (every, every[::-1]):
        force, tangent = some(order).force_and_tangent(motion)
        np.testing.assert_allclose(force, alone, atol=1e-12 * np.abs(alone).max())
        np.testing.assert_array_equal(tangent[1], 0)
    np.testing.assert_array_equal(
        some(every[::-1]).contact_state(motion), some(every).contact_state(motion)[::-1]
    )


def test_stuck_elements_are_springs_in_every_harmonic():
    law = ConstantLoad(np.array([0]), np.array([2e8]), np.array([30.0]))
    motion = 1e-8 * np.random.default_rng(0).normal(size=(1, 6))
    force, tangent = AlternatingFrequencyTime(law, 5).force_and_tangent(motion)
    np.testing.assert_allclose(force, 2e8 * motion, rtol=1e-12)
    np.testing.assert_allclose(tangent[0], 2e8 * np.eye(6), atol=1e-12 * 2e8)


def test_a_harmonic_motion_that_slips_has_a_force_of_odd_harmonics():
    """Full slip: a square wave against the velocity."""
    law = ConstantLoad(np.array([0]), np.array([1e12]), np.array([30.0]))
    force = AlternatingFrequencyTime(law, 5, samples=4096).force(np.array([[1e-3, 0, 0, 0, 0, 0]]))[
        0
    ]
    square = 4 * 30.0 / np.pi * np.array([0, 1, 0, -1 / 3, 0, 1 / 5])
    # it reverses within one of 2048 samples in half a period
    np.testing.assert_allclose(force, square, atol=30.0 / 500)


@both_laws
def test_one_harmonic_has_the_components_of_the_analytic_law(population):
    law, _ = population(5)
    aft = AlternatingFrequencyTime(law)
    for name in ("name", "directions", "components"):
        assert getattr(aft, name) == getattr(law, name)
    for name in ("point_of_element", "tangential_stiffness", "slip_force"):
        np.testing.assert_array_equal(getattr(aft, name), getattr(law, name))
    np.testing.assert_array_equal(aft.stuck_stiffness(5), law.stuck_stiffness(5))


def test_components_of_several_harmonics():
    constant, variable = constant_load(1)[0], variable_load(1)[0]
    assert AlternatingFrequencyTime(constant, 4).components == ("sin", "cos", "sin3", "cos3")
    assert AlternatingFrequencyTime(variable, 2).components == (
        "bias",
        "sin",
        "cos",
        "sin2",
        "cos2",
    )


@pytest.mark.parametrize(("harmonics", "samples"), [(5, 10), (1, 2)])
def test_too_few_samples_are_refused(harmonics, samples):
    message = f"samples is {samples}: it must be at least {2 * harmonics + 1}"
    with pytest.raises(ValueError, match=message):
        AlternatingFrequencyTime(constant_load(1)[0], harmonics, samples)


def test_without_a_harmonic_there_is_no_motion():
    with pytest.raises(ValueError, match="harmonics is 0: it must be at least 1"):
        AlternatingFrequencyTime(constant_load(1)[0], 0)
