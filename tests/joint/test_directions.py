"""Joints whose contact moves in both directions of its plane."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import connect_small

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.registry import LAWS
from boltjoint.joint.clusters import find_slip_states
from boltjoint.joint.derived import merge_points
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.joint.model import count_alike, keep_elements
from boltjoint.joint.node_to_node import connect_pairs
from boltjoint.verification.multi_harmonic import solve_periodic
from boltjoint.verification.time_integration import steady_state

IN_PLANE = ["uncoupled-constant", "uncoupled-variable", "coupled-constant", "coupled-variable"]

every_law = pytest.mark.parametrize("law", IN_PLANE)


def keys_of(law):
    keys = {"tangential_stiffness": 5e6, "friction_coefficient": 0.1}
    return keys | ({"normal_stiffness": 1e7} if law.endswith("variable") else {})


def planar_joint(law, samples=None):
    """The small bar, which moves along its width too; sampled where the law needs it."""
    base, preload = connect_small("variable", keys_of("variable"))
    x = base.position[:, 0]
    across = np.column_stack([0.02 + 0.5 * x, 0.08 - 0.6 * x, 0.1 * np.cos(50 * x)])
    relative = np.stack([base.tangential_mode, across, base.normal_mode])
    modes = preload[["position"]].assign(
        relative_mode=(("axis", "pair", "mode"), relative),
        **{
            name: ("mode", getattr(base, name))
            for name in ("natural_frequency", "excitation_mode", "response_mode")
        },
    )
    joint = connect_pairs(modes, preload, LAWS[law], **keys_of(law))
    if samples is None:
        return joint
    return replace(joint, law=AlternatingFrequencyTime(joint.law, samples=samples))


def quantities(law):
    return {name: getattr(law, name) for name in ("point_of_element", *law.quantities)}


@every_law
def test_rows_are_those_of_the_axes_and_survive_a_file(law):
    joint = planar_joint(law)
    lateral = 0.02 + 0.5 * joint.position[:, 0]
    np.testing.assert_allclose(joint.lateral_mode[:, 0], lateral)
    assert len(joint.rows) == len(joint.law.directions)
    assert joint.rows[1] is joint.lateral_mode
    again = joint_from_dataset(joint_to_dataset(joint))
    assert type(again.law) is type(joint.law)
    for one, other in zip(again.rows, joint.rows, strict=True):
        np.testing.assert_array_equal(one, other)


@every_law
def test_a_law_that_needs_the_lateral_mode_is_refused_without(law):
    joint = planar_joint(law)
    with pytest.raises(ValueError, match=f"{law}' needs a lateral mode"):
        replace(joint, lateral_mode=None)
    alone = LAWS[law.split("-")[1]](**quantities(joint.law))
    with pytest.raises(ValueError, match="has no use for a lateral mode"):
        replace(joint, law=alone)


@every_law
def test_regions_and_kept_elements_have_all_directions(law):
    joint = planar_joint(law)
    region = np.arange(joint.points) * 4 // joint.points
    regions = merge_points(joint, region)
    np.testing.assert_allclose(
        regions.lateral_mode[1], joint.lateral_mode[region == 1].mean(axis=0)
    )
    # two of each element are twice the joint
    twice = {name: np.repeat(values, 2, axis=0) for name, values in quantities(joint.law).items()}
    doubled = replace(
        joint,
        law=type(joint.law)(**twice),
        element_position=np.repeat(joint.element_position, 2, axis=0),
    )
    alike = count_alike(doubled)
    assert sorted(set(alike)) == [0, 2]
    kept = keep_elements(doubled, alike)
    np.testing.assert_allclose(kept.stuck_stiffness(), 2 * joint.stuck_stiffness())


@every_law
def test_slip_states_lie_between_stick_and_full_slip(law):
    joint = planar_joint(law)
    states = find_slip_states(joint, 2)
    stuck = joint.resonance_range()[:2, 1]
    np.testing.assert_allclose(states.frequency[0] / (2 * np.pi), stuck)
    assert np.all(np.diff(states.frequency, axis=0) < 0)


@every_law
def test_jacobian_equals_central_differences(law):
    samples = 64 if law.startswith("coupled") else None
    balance = HarmonicBalance(planar_joint(law, samples), 0.01, 20.0)
    w = 2 * np.pi * 75.0
    x = 3 * balance.stuck_solution(w)
    _, jacobian = balance.residual_and_jacobian(x, w)
    step = 1e-7 * np.abs(x).max()
    found = np.column_stack(
        [
            (balance.residual(x + step * e, w) - balance.residual(x - step * e, w)) / (2 * step)
            for e in np.eye(x.size)
        ]
    )
    np.testing.assert_allclose(jacobian(), found, atol=1e-6 * np.abs(found).max())


@every_law
def test_a_response_holds_when_friction_is_followed_in_time(law):
    samples = 512 if law.startswith("coupled") else None
    joint = planar_joint(law, samples)
    branch = solve_branch(joint, 20.0, damping=0.01, resonance=Resonance(1, (60.0, 90.0)))
    assert branch.complete and branch.peak is not None
    q = branch.modal_coordinate[branch.peak].reshape(len(joint.law.components), -1)
    elements = joint.law.elements if samples else joint.law
    states = joint.law.contact_state(np.hstack([B @ q.T for B in joint.rows]))
    assert (states > 0).mean() > 0.5
    motion = np.zeros((joint.points, 3, 3))
    first = 0 if len(q) == 3 else 1
    motion[:, : len(joint.rows), first:] = np.stack([B @ q.T for B in joint.rows], axis=1)
    force = elements.forces_in_time(motion.reshape(joint.points, 9), 1024)
    force = force.reshape(joint.points, 3, 3)[:, : len(joint.rows), first:]
    modal = sum(force[:, d].T @ B for d, B in enumerate(joint.rows))
    expected = HarmonicBalance(joint, 0.01, 20.0).contact.force(q.ravel(), 0.0).reshape(q.shape)
    # samples of both, which converge with their square
    np.testing.assert_allclose(modal, expected, atol=2e-3 * np.abs(expected).max())


@pytest.mark.parametrize("law", IN_PLANE[:2])
def test_time_integration_agrees_with_a_balance_of_many_harmonics(law):
    joint = planar_joint(law)
    at = joint, 80.0, 20.0, 0.05
    motion = solve_periodic(*at, harmonics=15, samples=256)
    found = steady_state(*at, steps=256, ramp=20, tolerance=1e-6)
    assert motion.converged and found.converged
    # what is left out above fifteen harmonics
    expected = motion.amplitude(joint.response_mode)
    assert abs(found.amplitude - expected) < 2e-3 * abs(expected)


def test_time_integration_refuses_sliders_in_the_plane():
    joint = planar_joint("coupled-constant")
    with pytest.raises(ValueError, match="move in the plane"):
        steady_state(joint, 75.0, 20.0, 0.01)
