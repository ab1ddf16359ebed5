"""Friction in both directions, uncoupled, against the laws of one direction."""

from dataclasses import replace

import numpy as np
import pytest
from planar_friction import CONSTANT, VARIABLE, constant_load, variable_load

from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.uncoupled import UncoupledConstantLoad, UncoupledVariableLoad
from boltjoint.friction.variable import VariableLoad

LAWS = {CONSTANT: UncoupledConstantLoad, VARIABLE: UncoupledVariableLoad}
ALONG = {CONSTANT: ConstantLoad, VARIABLE: VariableLoad}

both_loads = pytest.mark.parametrize("load", [CONSTANT, VARIABLE])


def population(load, count, harmonics=1, seed=0):
    """Elements, and their motion by direction."""
    return (constant_load if load == CONSTANT else variable_load)(count, harmonics, seed)


def along_each(found, motion, evaluate):
    """What the law of one direction gives along x, and along y; the normal force is last."""
    x, y, *normal = motion
    return [evaluate(np.hstack([each, *normal])) for each in (x, y)]


@both_loads
def test_forces_are_those_of_one_direction_with_the_normal_force_once(load):
    elements, motion = population(load, 2000)
    both, alone = LAWS[load](*elements), ALONG[load](*elements)
    count = motion[0].shape[1]
    in_x, in_y = along_each(both, motion, alone.force)
    expected = np.hstack([in_x[:, :count], in_y[:, :count], in_x[:, count:]])
    np.testing.assert_array_equal(both.force(np.hstack(motion)), expected)
    states = along_each(both, motion, alone.contact_state)
    np.testing.assert_array_equal(both.contact_state(np.hstack(motion)), np.maximum(*states))


@both_loads
def test_tangent_equals_central_differences(load):
    elements, motion = population(load, 300, seed=3)
    law, motion = LAWS[load](*elements), np.hstack(motion)
    force, tangent = law.force_and_tangent(motion)
    np.testing.assert_array_equal(force, law.force(motion))
    stiffness = np.maximum(law.tangential_stiffness, getattr(law, "normal_stiffness", 0))
    for j in range(motion.shape[1]):
        step = np.zeros_like(motion)
        step[:, j] = 1e-7 * np.abs(motion).max(axis=1)
        difference = (law.force(motion + step) - law.force(motion - step)) / (2 * step[:, j, None])
        error = np.abs(tangent[:, :, j] - difference).max(axis=1) / stiffness
        assert error.max() < 1e-6


@both_loads
@pytest.mark.parametrize("harmonics", [1, 3])
def test_sampled_forces_are_those_of_one_direction(load, harmonics):
    elements, motion = population(load, 300, harmonics, seed=1)
    both, alone = (
        AlternatingFrequencyTime(laws[load](*elements), harmonics, samples=64)
        for laws in (LAWS, ALONG)
    )
    count = motion[0].shape[1]
    (in_x, by_x), (in_y, by_y) = along_each(both, motion, alone.force_and_tangent)
    force, tangent = both.force_and_tangent(np.hstack(motion))
    expected = np.hstack([in_x[:, :count], in_y[:, :count], in_x[:, count:]])
    np.testing.assert_array_equal(force, expected)
    x, y, normal = np.arange(tangent.shape[1]).reshape(-1, count)[[0, 1, -1]]
    np.testing.assert_array_equal(tangent[:, x[:, None], x], by_x[:, :count, :count])
    np.testing.assert_array_equal(tangent[:, y[:, None], y], by_y[:, :count, :count])
    assert not tangent[:, x[:, None], y].any()
    if load == VARIABLE:
        np.testing.assert_array_equal(tangent[:, y[:, None], normal], by_y[:, :count, count:])
        np.testing.assert_array_equal(tangent[:, normal[:, None], normal], by_x[:, count:, count:])
        assert not tangent[:, normal[:, None], y].any()
    states = along_each(both, motion, alone.contact_state)
    np.testing.assert_array_equal(both.contact_state(np.hstack(motion)), np.maximum(*states))


@both_loads
def test_modal_forces_are_projections_of_those_of_the_points(load):
    elements, _ = population(load, 200)
    random = np.random.default_rng(6)
    law = replace(LAWS[load](*elements), point_of_element=random.integers(0, 80, 200))
    aft = AlternatingFrequencyTime(law, 3, samples=64)
    rows = tuple(random.normal(size=(80, 3)) for _ in law.directions)
    count = len(aft.components)
    amplitude = 3e-6 * random.normal(size=(count, 3))
    motion = np.hstack([B @ amplitude.T for B in rows])
    assert len(set(aft.contact_state(motion))) > 1
    force, tangent = aft.force_and_tangent(motion)
    expected = np.einsum("dpr,pdi->ir", rows, force.reshape(80, -1, count))
    blocks = tangent.reshape(80, len(rows), count, len(rows), count)
    expected_tangent = np.einsum("dpr,pdiej,eps->irjs", rows, blocks, rows, optimize=True)
    found, found_tangent = aft.modal_force_and_tangent(rows, amplitude, 0.0)
    # sums in another order
    np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(expected).max())
    largest = np.abs(expected_tangent).max()
    np.testing.assert_allclose(found_tangent(), expected_tangent, atol=1e-10 * largest)


@both_loads
def test_forces_in_time_and_aft_agree_to_rounding_at_the_same_samples(load):
    elements, motion = population(load, 300, seed=2)
    law, motion = LAWS[load](*elements), np.hstack(motion)
    other = AlternatingFrequencyTime(law, samples=200).force(motion)
    in_time = motion
    if load == CONSTANT:
        # AFT of this law knows no bias
        in_time = np.zeros((len(motion), 9))
        in_time[:, [1, 2, 4, 5]] = motion
    found = law.forces_in_time(in_time, 200)
    found = found[:, [1, 2, 4, 5]] if load == CONSTANT else found
    np.testing.assert_allclose(found, other, atol=1e-11 * np.abs(other).max())


@both_loads
def test_stuck_stiffness_is_the_tangent_of_small_motion(load):
    elements, motion = population(load, 50)
    law = LAWS[load](*elements)
    _, tangent = law.force_and_tangent(1e-9 * np.hstack(motion))
    count = motion[0].shape[1]
    diagonal = tangent[:, np.arange(tangent.shape[1]), np.arange(tangent.shape[1])]
    np.testing.assert_array_equal(diagonal[:, ::count], law.stuck_stiffness(50))
