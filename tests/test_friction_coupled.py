"""Friction in both directions with a circular limit: closed forms, invariances, tangents."""

from dataclasses import replace

import numpy as np
import pytest
from planar_friction import CONSTANT, VARIABLE, constant_load, variable_load

from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.coupled import CoupledConstantLoad, CoupledVariableLoad
from boltjoint.friction.coupled_kernels import _follow_period
from boltjoint.friction.uncoupled import UncoupledConstantLoad
from boltjoint.friction.variable import VariableLoad

LAWS = {CONSTANT: CoupledConstantLoad, VARIABLE: CoupledVariableLoad}
ALONG = {CONSTANT: ConstantLoad, VARIABLE: VariableLoad}
POPULATIONS = {CONSTANT: constant_load, VARIABLE: variable_load}

both_loads = pytest.mark.parametrize("load", [CONSTANT, VARIABLE])


def largest_forces(load, elements, motion):
    """The largest friction and, under variable load, normal force of each element."""
    if load == CONSTANT:
        return np.repeat(elements[2][:, None], 2 * motion[0].shape[1], axis=1)
    normal = np.abs(elements[3]) + elements[2] * np.abs(motion[2]).sum(axis=1)
    friction = elements[4] * normal
    return np.repeat(np.stack([friction, friction, normal], axis=1), motion[0].shape[1], axis=1)


def turned(motion, angle):
    """Motions or forces of the plane turned about the normal of the contact."""
    x, y, *normal = motion
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return [cosine * x - sine * y, sine * x + cosine * y, *normal]


def circular_orbits(ratios):
    """Elements on circles of these radii, over mu n / k; closed form of their forces."""
    ratios = np.asarray(ratios)
    count = ratios.size
    k, slip = np.geomspace(1e6, 1e9, count), np.geomspace(1e3, 1, count)
    A = ratios * slip / k
    zero = np.zeros(count)
    # x = A sin(wt), y = A cos(wt)
    motion = np.column_stack([A, zero, zero, A])
    lead = np.arccos(1 / ratios)
    f = slip * np.cos(lead), slip * np.sin(lead)
    exact = np.column_stack([f[0], f[1], -f[1], f[0]])
    return CoupledConstantLoad(np.arange(count), k, slip), motion, exact


def as_in_time(motion):
    """Motion without bias and normal part as ``forces_in_time`` takes it."""
    whole = np.zeros((len(motion), 9))
    whole[:, [1, 2, 4, 5]] = motion
    return whole


@pytest.mark.parametrize("method", ["aft", "in time"])
def test_forces_on_circular_orbits_converge_to_the_closed_form(method):
    law, motion, exact = circular_orbits([1.01, 1.2, 2, 5, 20])
    counts = 2 ** np.arange(6, 11)
    errors = []
    for count in counts:
        if method == "aft":
            found = AlternatingFrequencyTime(law, samples=int(count)).force(motion)
        else:
            found = law.forces_in_time(as_in_time(motion), int(count))[:, [1, 2, 4, 5]]
        errors.append(np.abs(found - exact).max(axis=1) / law.slip_force)
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    np.testing.assert_allclose(order, 2, atol=0.2)
    assert np.max(errors[-1]) < 2e-4


def test_dissipation_on_circular_orbits_is_that_of_the_closed_form():
    law, motion, _ = circular_orbits([1.1, 2, 10])
    f = AlternatingFrequencyTime(law, samples=1024).force(motion)
    # the work of a harmonic force: pi (f_c s - f_s c)
    work = np.pi * (f[:, 1::2] * motion[:, ::2] - f[:, ::2] * motion[:, 1::2]).sum(axis=1)
    limit = law.slip_force / law.tangential_stiffness
    radius = np.sqrt(motion[:, 0] ** 2 - limit**2)
    np.testing.assert_allclose(work, 2 * np.pi * law.slip_force * radius, rtol=1e-4)


def test_within_the_limit_a_circular_orbit_sticks():
    law, motion, _ = circular_orbits([1.5, 3])
    motion = motion / 3.001
    aft = AlternatingFrequencyTime(law, samples=64)
    force, tangent = aft.force_and_tangent(motion)
    k = law.tangential_stiffness[:, None]
    np.testing.assert_allclose(force, k * motion, rtol=0, atol=1e-13 * law.slip_force[0])
    np.testing.assert_allclose(tangent / k[:, None], np.stack([np.eye(4)] * 2), atol=1e-13)
    assert not aft.contact_state(motion).any()


@both_loads
@pytest.mark.parametrize("harmonics", [1, 3])
def test_a_straight_orbit_in_any_direction_is_the_law_of_one_direction(load, harmonics):
    elements, (x, _, *normal) = POPULATIONS[load](2000, harmonics)
    angle = np.random.default_rng(5).uniform(0, 2 * np.pi, 2000)
    both, alone = (
        AlternatingFrequencyTime(laws[load](*elements), harmonics, samples=64)
        for laws in (LAWS, ALONG)
    )
    straight = np.hstack([x, *normal])
    along = alone.force(straight)
    f, *of_normal = np.split(along, len(alone.directions), axis=1)
    motion = turned([x, 0 * x, *normal], angle)
    expected = np.hstack(turned([f, 0 * f, *of_normal], angle))
    error = (both.force(np.hstack(motion)) - expected) / largest_forces(load, elements, motion)
    # rounding of displacements that are up to a hundred times those that slip
    assert np.abs(error).max() < 1e-13
    states = alone.contact_state(straight)
    assert len(set(states)) == (2 if load == CONSTANT else 4)
    np.testing.assert_array_equal(both.contact_state(np.hstack(motion)), states)


@both_loads
def test_turned_axes_turn_the_forces(load):
    elements, motion = POPULATIONS[load](500, seed=1)
    aft = AlternatingFrequencyTime(LAWS[load](*elements), samples=64)
    angle = np.random.default_rng(5).uniform(0, 2 * np.pi, 500)
    force = np.split(aft.force(np.hstack(motion)), len(aft.directions), axis=1)
    found = aft.force(np.hstack(turned(motion, angle)))
    error = (found - np.hstack(turned(force, angle))) / largest_forces(load, elements, motion)
    # the slider is periodic to 1e-10 of the limit
    assert np.abs(error).max() < 1e-9


@both_loads
@pytest.mark.parametrize("harmonics", [1, 4])
def test_tangent_equals_central_differences(load, harmonics):
    elements, motion = POPULATIONS[load](300, harmonics, seed=7)
    law, motion = LAWS[load](*elements), np.hstack(motion)
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


def narrow_orbits(count):
    """Elements on narrow ellipses that slip little, and their motion.

    Their friction turns by 1e-4 to 1e-2 of what is left a period.
    """
    random = np.random.default_rng(3)
    one = np.ones(count)
    law = CoupledVariableLoad(np.arange(count), one, one, one, one)
    a, b = 1 + 10 ** random.uniform(-4, -1, count), 10 ** random.uniform(-2.5, -0.3, count)
    v, zero = random.uniform(0, 0.3, (2, count)), np.zeros(count)
    return law, np.column_stack([zero, zero, a, zero, b, zero, zero, *v])


def test_friction_that_turns_slowly_is_that_of_many_periods():
    one = np.ones(1)
    law = CoupledVariableLoad(np.arange(1), one, one, one, one)
    # at rest after 4289 periods, and 3.6e-4 of its limit away from there after 1000
    motion = np.array([[0, 0, 1.000241, 0, 0.39631, 0, 0, -0.033, 0.267]])
    count = 256
    phase = 2 * np.pi * np.arange(count) / count
    synthesis = np.array([np.ones(count), np.sin(phase), np.cos(phase)])
    x, y, v = motion.reshape(3, 3) @ synthesis
    loading, z, friction = (np.stack([x, y]), 1 + v, 1 + v), np.zeros(2), np.empty((2, count))
    at_rest = np.zeros((count, 1))
    derivative, of_motion = np.empty((0, 6)), (at_rest, at_rest, at_rest)
    unused = np.zeros((2, 1)), derivative, friction, np.zeros((1, 2, 1))
    for _ in range(6000):
        _follow_period(loading, of_motion, 0.0, z, *unused)
    expected = (friction @ synthesis.T / [count, count / 2, count / 2]).ravel()
    force = AlternatingFrequencyTime(law, 1, samples=count).force(motion)
    np.testing.assert_allclose(force[0, :6], expected, atol=1e-7)


def test_tangent_of_friction_that_turns_slowly_equals_central_differences():
    law, motion = narrow_orbits(60)
    aft = AlternatingFrequencyTime(law, 1, samples=256)
    tangent = aft.force_and_tangent(motion)[1]
    for j in range(motion.shape[1]):
        step = 1e-7 * np.eye(motion.shape[1])[j]
        difference = (aft.force(motion + step) - aft.force(motion - step)) / 2e-7
        np.testing.assert_allclose(tangent[:, :, j], difference, atol=1e-4)


def test_tangent_of_circular_orbits_is_that_of_the_closed_form():
    law, motion, _ = circular_orbits([1.2, 2, 5])
    tangent = AlternatingFrequencyTime(law, samples=2048).force_and_tangent(motion)[1]
    limit = law.slip_force / law.tangential_stiffness
    A, k = motion[:, 0], law.tangential_stiffness
    by_A = np.einsum("pij,pj->pi", tangent, motion / A[:, None])
    ratio = limit / A
    # of the friction mu n (ratio, sqrt(1 - ratio^2)), in phase and in quadrature
    in_phase = -k * ratio**2
    quadrature = k * ratio**3 / np.sqrt(1 - ratio**2)
    expected = np.column_stack([in_phase, quadrature, -quadrature, in_phase])
    np.testing.assert_allclose(by_A / k[:, None], expected / k[:, None], atol=2e-4)


@both_loads
def test_forces_in_time_and_aft_converge_to_the_same(load):
    elements, motion = POPULATIONS[load](60, seed=4)
    law, largest = LAWS[load](*elements), largest_forces(load, elements, motion)
    motion = np.hstack(motion)
    differences = []
    for count in (128, 512):
        other = AlternatingFrequencyTime(law, samples=count).force(motion)
        if load == CONSTANT:
            found = law.forces_in_time(as_in_time(motion), count)[:, [1, 2, 4, 5]]
        else:
            found = law.forces_in_time(motion, count)
        differences.append(np.std((found - other) / largest))
    assert differences[1] < 2e-4
    # of second order: a sixteenth with four times the samples
    assert differences[1] < differences[0] / 8


def test_a_load_that_nothing_changes_is_a_constant_one():
    (on, k, slip), (x, y) = constant_load(200)
    zero = np.zeros((200, 1))
    variable = CoupledVariableLoad(on, k, k, slip / 0.3, np.full(200, 0.3))
    motion = np.hstack([zero, x, zero, y, np.zeros((200, 3))])
    found = AlternatingFrequencyTime(variable, samples=64).force(motion)
    constant = AlternatingFrequencyTime(CoupledConstantLoad(on, k, slip), samples=64)
    expected = constant.force(np.hstack([x, y]))
    error = (found[:, [1, 2, 4, 5]] - expected) / slip[:, None]
    assert np.abs(error).max() < 1e-9
    assert np.abs(found[:, 6:]).max() < 1e-12 * slip.max()


@both_loads
def test_elements_on_one_point_add_up(load):
    elements, motion = POPULATIONS[load](100, seed=3)
    on = np.random.default_rng(4).choice([0, 2], 100)
    law, motion = LAWS[load](*elements), np.hstack(motion)[:3]
    together = AlternatingFrequencyTime(replace(law, point_of_element=on), samples=64)
    alone = AlternatingFrequencyTime(law, samples=64)
    force, tangent = together.force_and_tangent(motion)
    forces, tangents = alone.force_and_tangent(motion[on])
    for p in range(3):
        np.testing.assert_allclose(force[p], forces[on == p].sum(axis=0), rtol=1e-9)
        largest = 1e-12 * np.abs(tangents).max()
        np.testing.assert_allclose(tangent[p], tangents[on == p].sum(axis=0), atol=largest)


@both_loads
def test_without_samples_the_law_is_refused(load):
    elements, motion = POPULATIONS[load](3)
    law, motion = LAWS[load](*elements), np.hstack(motion)
    for evaluate in (law.force, law.force_and_tangent, law.contact_state):
        with pytest.raises(ValueError, match="no closed form"):
            evaluate(motion)
    assert law.sliders() is None


@pytest.mark.parametrize("ratio", [1.1, 1.5, 2.0, 3.0, 5.0, 10.0])
def test_dissipation_of_uncoupled_elements_over_that_of_coupled_ones(ratio):
    """What docs/friction.md says of circular orbits and of straight ones at 45 degrees."""
    law, circle, _ = circular_orbits([ratio])
    elements = law.point_of_element, law.tangential_stiffness, law.slip_force
    diagonal = np.array([[1.0, 0.0, 1.0, 0.0]]) * circle[0, 0] / np.sqrt(2)
    expected = {
        "circle": 4 / np.pi * np.sqrt((ratio - 1) / (ratio + 1)),
        "diagonal": max(np.sqrt(2) * (ratio - np.sqrt(2)) / (ratio - 1), 0.0),
    }
    for orbit, motion in (("circle", circle), ("diagonal", diagonal)):
        work = []
        for each in (UncoupledConstantLoad(*elements), law):
            f = AlternatingFrequencyTime(each, samples=2048).force(motion)
            work.append((f[:, 1::2] * motion[:, ::2] - f[:, ::2] * motion[:, 1::2]).sum())
        # sampled forces
        assert work[0] / work[1] == pytest.approx(expected[orbit], abs=2e-3)
