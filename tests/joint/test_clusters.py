"""Clusters of pairs of similar motion."""

from dataclasses import replace

import numpy as np
import pytest
from joint_examples import frozen_in_groups
from small_joint import make_joint

from boltjoint.joint.clusters import cluster_by_motion

LAWS = ("constant", "variable")


@pytest.mark.parametrize("law", LAWS)
def test_pairs_of_equal_motion_are_one_cluster(law):
    joint, group = frozen_in_groups(law)
    region = cluster_by_motion(joint, 5)
    # a region for each group: the pairs (region, group) that occur are as many as either
    assert len(set(zip(region, group, strict=True))) == 5
    assert np.unique(region).size == 5


@pytest.mark.parametrize("law", LAWS)
def test_pairs_of_equal_motion_are_one_cluster_whatever_their_stiffness(law):
    joint, group = frozen_in_groups(law)
    factor = 10 ** np.random.default_rng(3).uniform(-1, 1, joint.law.tangential_stiffness.size)
    changed = {
        name: factor * getattr(joint.law, name)
        for name, (unit, _) in joint.law.quantities.items()
        if unit != "1"
    }
    region = cluster_by_motion(replace(joint, law=replace(joint.law, **changed)), 5)
    assert len(set(zip(region, group, strict=True))) == 5


@pytest.mark.parametrize("law", LAWS)
def test_every_count_up_to_that_of_the_pairs_is_met(law):
    joint, _ = frozen_in_groups(law)
    for count in (1, 4, 5, 6, 30, 60):
        np.testing.assert_array_equal(np.unique(cluster_by_motion(joint, count)), np.arange(count))


def test_clusters_do_not_depend_on_units_of_load_and_stiffness_alike(joint):
    # twice the frequency squared, stiffness and load: the same motion
    law = joint.law
    stiffer = replace(
        joint,
        natural_frequency=np.sqrt(2) * joint.natural_frequency,
        law=replace(
            law, tangential_stiffness=2 * law.tangential_stiffness, slip_force=2 * law.slip_force
        ),
    )
    np.testing.assert_array_equal(cluster_by_motion(stiffer, 6), cluster_by_motion(joint, 6))


@pytest.mark.parametrize("law", LAWS)
def test_clusters_are_numbered_along_the_bar(law):
    joint = make_joint(law=law)
    region = cluster_by_motion(joint, 6)
    centre = np.bincount(region, joint.position[:, 0]) / np.bincount(region)
    assert np.all(np.diff(centre) > 0)


def test_clusters_follow_the_motion_of_the_compared_resonances(joint):
    # contact so soft that modes stay as they are; one row varies by half, the other by quarter
    half, quarter = np.repeat([0, 1], 30), np.tile(np.repeat([0, 1], 15), 2)
    tangential = np.column_stack([1.0 + half, 50.0 * (1 + quarter), np.ones(60)])
    law = replace(joint.law, tangential_stiffness=np.full(60, 1e-6))
    joint = replace(joint, tangential_mode=tangential, law=law)
    np.testing.assert_array_equal(cluster_by_motion(joint, 2), half)
    of_two = cluster_by_motion(joint, 2, resonances=2)
    # one of the two orders in which regions may be numbered
    assert np.array_equal(of_two, quarter) or np.array_equal(of_two, 1 - quarter)


@pytest.mark.parametrize("resonances", [0, 4])
def test_resonances_that_a_joint_has_not_are_refused(joint, resonances):
    with pytest.raises(
        ValueError, match=f"resonances is {resonances}: it must be at least 1 and at most 3"
    ):
        cluster_by_motion(joint, 4, resonances=resonances)
