"""Joints: their parts, stiffness and regions."""

from dataclasses import replace

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.joint.derived import merge_points


def test_parts_that_do_not_fit_are_refused(joint):
    with pytest.raises(ValueError, match="tangential_mode has shape"):
        replace(joint, tangential_mode=joint.tangential_mode[:-1])
    with pytest.raises(ValueError, match="elements must sit on points"):
        replace(joint, law=replace(joint.law, point_of_element=joint.law.point_of_element + 1))
    for nothing in ((), np.empty(0)):
        with pytest.raises(ValueError, match="places is of type"):
            replace(joint, places=nothing)


def test_a_law_has_the_normal_rows_it_needs_and_no_others(joint):
    with pytest.raises(ValueError, match="the law 'constant' has no use for a normal mode"):
        replace(joint, normal_mode=joint.tangential_mode)
    variable = make_joint(law="variable")
    with pytest.raises(ValueError, match="the law 'variable' needs a normal mode"):
        replace(variable, normal_mode=None)
    with pytest.raises(ValueError, match="normal_mode has shape"):
        replace(variable, normal_mode=variable.normal_mode[:, :-1])


def test_stuck_stiffness_is_that_of_the_springs(joint):
    R, k = joint.tangential_mode, joint.law.tangential_stiffness
    np.testing.assert_allclose(joint.stuck_stiffness(), R.T @ np.diag(k) @ R)


def test_stuck_stiffness_has_the_springs_of_closed_elements_in_both_directions():
    joint = make_joint(law="variable")
    law, closed = joint.law, joint.law.normal_load > 0
    assert 0 < closed.sum() < closed.size
    expected = sum(
        B[closed].T @ np.diag(k[closed]) @ B[closed]
        for B, k in zip(
            (joint.tangential_mode, joint.normal_mode),
            (law.tangential_stiffness, law.normal_stiffness),
            strict=True,
        )
    )
    np.testing.assert_allclose(joint.stuck_stiffness(), expected)


def test_regions_of_one_pair_each_are_the_node_to_node_joint(either):
    regions = merge_points(either, np.arange(either.points))
    for one, other in zip(regions.rows, either.rows, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(regions.law.point_of_element, either.law.point_of_element)


def test_a_region_moves_as_the_mean_of_its_pairs(either):
    regions = merge_points(either, np.repeat([0, 1], [20, 40]))
    for one, other in zip(regions.rows, either.rows, strict=True):
        np.testing.assert_allclose(one[0], other[:20].mean(axis=0))
        np.testing.assert_allclose(one[1], other[20:].mean(axis=0))
    np.testing.assert_allclose(regions.position[1], either.position[20:].mean(axis=0))


def test_a_region_keeps_every_element(either):
    regions = merge_points(either, np.repeat([0, 1], [20, 40]))
    for name in either.law.quantities:
        assert getattr(regions.law, name) is getattr(either.law, name)
    np.testing.assert_array_equal(regions.element_position, either.element_position)
    np.testing.assert_array_equal(regions.law.point_of_element, np.repeat([0, 1], [20, 40]))


def test_every_point_needs_a_region_and_every_region_a_point(joint):
    with pytest.raises(ValueError, match="region must count from 0 without gaps: no point has 1"):
        merge_points(joint, np.repeat([0, 2], [20, 40]))
    with pytest.raises(ValueError, match=r"region has shape \(59,\), expected \(60,\)"):
        merge_points(joint, np.repeat([0, 1], [20, 39]))


def test_weights_count_in_the_mean_of_a_region(either):
    region, weight = np.repeat([0, 1], [20, 40]), np.linspace(0, 3, 60)
    regions = merge_points(either, region, weight)
    for one, other in zip(regions.rows, either.rows, strict=True):
        np.testing.assert_allclose(one[0], np.average(other[:20], axis=0, weights=weight[:20]))
        np.testing.assert_allclose(one[1], np.average(other[20:], axis=0, weights=weight[20:]))
    # only ratios of weights matter; but for rounding
    for one, other in zip(merge_points(either, region, 7 * weight).rows, regions.rows, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)


def test_weights_that_leave_a_region_without_a_mean_are_refused(joint):
    region = np.repeat([0, 1], [20, 40])
    with pytest.raises(ValueError, match="weight is zero in all of region 0"):
        merge_points(joint, region, np.repeat([0.0, 1], [20, 40]))
    with pytest.raises(ValueError, match="weight must be at least 0, but is -1 at index 59"):
        merge_points(joint, region, np.repeat([1.0, -1], [59, 1]))


def test_a_joint_is_told_in_a_line(either):
    elements = f"60 elements ({either.law.name})"
    assert repr(either) == f"<Joint of {elements} on 60 contact points, in 3 modes>"


def test_a_joint_draws_its_elements_where_they_are(joint):
    matplotlib.use("agg")
    plt.figure()
    described = joint.to_dataset()
    assert described.sizes == {"element": joint.law.point_of_element.size}
    np.testing.assert_array_equal(described["slip_force"], joint.law.slip_force)
    assert described["tangential_stiffness"].attrs["units"] == "N/m"
    drawn = joint.plot("tangential_stiffness")
    np.testing.assert_array_equal(drawn.get_offsets(), joint.element_position[:, :2])
    np.testing.assert_array_equal(drawn.get_array(), joint.law.tangential_stiffness)
    with pytest.raises(ValueError, match="name 'colour' is not known; allowed: slip_force"):
        joint.plot("colour")
    plt.close()
