"""Friction of sliders followed in time against closed forms and AFT."""

import numpy as np
import pytest

from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.slider_forms import integrate_friction
from boltjoint.friction.variable import VariableLoad


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


def test_forces_in_time_converge_to_the_exact_ones_with_second_order():
    elements, motion = random_elements(1000)
    law = VariableLoad(*elements)
    exact = law.force(motion)
    load = np.abs(law.normal_load) + law.normal_stiffness * np.abs(motion[:, 3:]).sum(axis=1)
    counts = 100 * 2 ** np.arange(6)
    errors = [
        np.std((law.forces_in_time(motion, count) - exact) / load[:, None]) for count in counts
    ]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order == pytest.approx(2, abs=0.2)


def test_forces_in_time_and_aft_agree_to_rounding_at_the_same_samples():
    elements, motion = random_elements(300, seed=1)
    law = VariableLoad(*elements)
    other = AlternatingFrequencyTime(law, samples=200).force(motion)
    tolerance = 1e-11 * np.abs(other).max()
    np.testing.assert_allclose(law.forces_in_time(motion, 200), other, atol=tolerance)
    on, k, _, load, mu = elements
    law = ConstantLoad(on, k, mu * np.abs(load))
    # AFT of this law knows no bias
    motion[:, 0] = 0.0
    other = AlternatingFrequencyTime(law, samples=200).force(motion[:, 1:3])
    found = law.forces_in_time(motion, 200)
    np.testing.assert_allclose(found[:, 1:3], other, atol=1e-11 * np.abs(other).max())
    assert not found[:, 3:].any()


def test_a_load_that_nothing_changes_is_a_constant_one():
    (on, k_u, k_v, load, mu), motion = random_elements(300, seed=2)
    load = np.abs(load)
    motion[:, [0, 3, 4, 5]] = 0.0
    in_time = VariableLoad(on, k_u, k_v, load, mu).forces_in_time(motion, 200)
    constant = ConstantLoad(on, k_u, mu * load).forces_in_time(motion, 200)
    np.testing.assert_allclose(in_time[:, 1:3], constant[:, 1:3], rtol=1e-9)
    np.testing.assert_allclose(in_time[:, 3:], 0, atol=1e-12 * load.max())


def test_elements_on_one_point_add_up():
    (_, *elements), motion = random_elements(200, seed=3)
    on, motion = np.random.default_rng(4).choice([0, 2], 200), motion[:3]
    together = VariableLoad(on, *elements).forces_in_time(motion, 100)
    alone = VariableLoad(np.arange(200), *elements).forces_in_time(motion[on], 100)
    for p in range(3):
        np.testing.assert_allclose(together[p], alone[on == p].sum(axis=0), rtol=1e-9)


def test_a_slider_without_friction_that_opens_pulls_nothing():
    """Nothing moves it along, and it is in no state that its springs alone would tell."""
    motion = np.array([[0.0, 0.0, 0.0, 0.0, 2e-6, 0.0]])
    sliders = [np.array([value]) for value in (1e6, 1e6, 1.0, 0.0)]
    force = integrate_friction(np.zeros(1, int), *sliders, motion, 4000)
    phase = 2 * np.pi * np.arange(4000) / 4000
    load = np.maximum(1.0 + 2.0 * np.sin(phase), 0.0)
    expected = [load.mean() - 1.0, 2 * np.mean(load * np.sin(phase)), 0.0]
    np.testing.assert_allclose(force[0, 3:], expected, atol=1e-6)
    assert not force[0, :3].any()
