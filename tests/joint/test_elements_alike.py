"""Elements with a weight stand for several: their forces, and joints of which some are alike."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.joint.derived import merge_points
from boltjoint.joint.model import count_alike, keep_elements


@pytest.mark.parametrize("law", ["constant", "variable", "iwan"])
def test_a_kept_element_bears_its_force_times_its_weight(law):
    joint, random = make_joint(law=law), np.random.default_rng(0)
    weight = random.uniform(0.5, 20.0, joint.points) * (random.random(joint.points) < 0.3)
    kept, points = keep_elements(joint, weight), np.flatnonzero(weight)
    columns = len(joint.rows) * len(joint.law.components)
    motion = 10 ** random.uniform(-8, -4, (joint.points, 1)) * random.normal(
        size=(joint.points, columns)
    )
    expected = weight[points, None] * joint.law.force(motion)[points]
    np.testing.assert_allclose(kept.law.force(motion[points]), expected, rtol=1e-12, atol=1e-12)
    assert np.array_equal(
        kept.law.contact_state(motion[points]), joint.law.contact_state(motion)[points]
    )
    np.testing.assert_array_equal(kept.position, joint.position[points])
    np.testing.assert_array_equal(kept.tangential_mode, joint.tangential_mode[points])


def test_points_keep_those_of_their_elements_that_have_a_weight():
    regions = merge_points(make_joint(), np.arange(60) // 20)
    weight = np.zeros(60)
    weight[[3, 5, 45]] = 1.0, 2.0, 3.0
    kept = keep_elements(regions, weight)
    assert kept.points == 2
    np.testing.assert_array_equal(kept.law.point_of_element, [0, 0, 1])
    np.testing.assert_array_equal(kept.tangential_mode, regions.tangential_mode[[0, 2]])
    expected = [1.0, 2.0, 3.0] * regions.law.slip_force[[3, 5, 45]]
    np.testing.assert_array_equal(kept.law.slip_force, expected)


@pytest.mark.parametrize("weight", [np.zeros(60), np.full(60, -1.0), np.ones(59)])
def test_impossible_weights_are_refused(weight):
    with pytest.raises(ValueError, match="weight"):
        keep_elements(make_joint(), weight)


def mirrored(joint):
    """The joint twice: every point at y and at -y, each with half of the forces."""
    half = keep_elements(joint, np.full(joint.points, 0.5))
    law, order = half.law, np.random.default_rng(3).permutation(2 * joint.points)
    of = np.tile(np.arange(joint.points), 2)[order]
    quantities = {name: getattr(law, name)[of] for name in law.quantities}
    position = np.vstack([half.position, half.position * [1, -1, 1]])[order]
    return replace(
        half,
        law=type(law)(np.arange(of.size), **quantities),
        tangential_mode=half.tangential_mode[of],
        normal_mode=None if half.normal_mode is None else half.normal_mode[of],
        position=position,
        element_position=position,
    )


@pytest.mark.parametrize("law", ["constant", "variable", "iwan"])
def test_points_that_are_alike_become_one(law):
    joint = make_joint(law=law)
    twice = mirrored(joint)
    # rounding as in modes of a symmetric structure
    noise = 1 + 1e-14 * np.random.default_rng(4).normal(size=twice.tangential_mode.shape)
    twice = replace(twice, tangential_mode=twice.tangential_mode * noise)
    assert sorted(count_alike(twice)) == [0] * 60 + [2] * 60
    merged = twice.distinct
    assert merged.points == 60
    order = np.argsort(merged.position[:, 0])
    for name in joint.law.quantities:
        expected = getattr(joint.law, name)[np.argsort(joint.position[:, 0])]
        np.testing.assert_allclose(getattr(merged.law, name)[order], expected, rtol=1e-15)


@pytest.mark.parametrize("law", ["constant", "variable"])
@pytest.mark.parametrize("coordinates", ["linear", "backbone", "complex-rdnm-1"])
def test_responses_of_a_joint_and_of_its_mirrored_twin_are_the_same(law, coordinates):
    joint = make_joint(law=law)
    one, other = (
        solve_branch(each, 20.0, method=coordinates, damping=0.01)
        for each in (joint, mirrored(joint))
    )
    np.testing.assert_allclose(other.frequency, one.frequency, rtol=1e-9)  # flat peaks
    np.testing.assert_allclose(other.amplitude, one.amplitude, rtol=1e-9)


def test_contact_states_are_those_of_all_elements():
    twice = mirrored(make_joint())
    states = solve_response(twice, [5.0], damping=0.01)["contact_state"].to_numpy()[0]
    assert states.size == 120
    assert np.unique(states).size == 2
    for x in np.unique(twice.position[:, 0]):
        assert np.unique(states[twice.position[:, 0] == x]).size == 1


def test_points_that_differ_are_kept():
    joint = make_joint()
    assert joint.distinct is joint
    # one quantity, or one mode
    twice = mirrored(joint)
    slip = twice.law.slip_force * np.linspace(1, 1.001, 120)
    assert replace(twice, law=replace(twice.law, slip_force=slip)).distinct.points == 120
    mode = twice.tangential_mode + np.linspace(0, 1e-6, 120)[:, None] * [0, 0, 1]
    assert replace(twice, tangential_mode=mode).distinct.points == 120


def test_alike_elements_of_a_region_become_one():
    region = np.arange(60) // 20
    regions = merge_points(make_joint(), region)
    twice = mirrored(make_joint())
    order = np.argsort(twice.position[:, 0], kind="stable")
    of_twice = np.empty(120, int)
    of_twice[order] = np.repeat(region, 2)
    merged = merge_points(twice, of_twice).distinct
    assert merged.law.slip_force.size == 60
    np.testing.assert_allclose(merged.tangential_mode, regions.tangential_mode, rtol=1e-12)
    for each in range(3):
        one, other = (
            np.sort(j.law.slip_force[j.law.point_of_element == each]) for j in (regions, merged)
        )
        np.testing.assert_allclose(other, one, rtol=1e-15)
