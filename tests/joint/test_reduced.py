"""Joints of fitted elements."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import FRICTION, make_joint, make_preload

from boltjoint.joint.derived import merge_points
from boltjoint.joint.fit_jenkins import fit_elements
from boltjoint.joint.hysteresis import loop_error
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import fit_reduced_joint


def regions_of(joint, count):
    return partition_regions(joint, make_preload(joint), count)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_reduced_joint_keeps_points_and_the_totals_of_what_carries_load(law):
    regions = regions_of(make_joint(law=law), 3)
    reduced, fit = fit_reduced_joint(regions, 2)
    for one, other in zip(reduced.rows, regions.rows, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(reduced.law.point_of_element, [0, 0, 1, 1, 2, 2])
    np.testing.assert_array_equal(reduced.element_position, regions.position[[0, 0, 1, 1, 2, 2]])
    closed = regions.law.slip_force > 0
    names = {"slip_force", *regions.law.quantities} - {"friction_coefficient"}
    for name in names:
        np.testing.assert_allclose(
            np.bincount(reduced.law.point_of_element, getattr(reduced.law, name)),
            np.bincount(regions.law.point_of_element, getattr(regions.law, name) * closed),
        )
    assert fit["loop_force_of_fit"].dims == ("point", "loop", "sample")
    assert fit.sizes["loop"] == 3


def test_elements_without_load_take_no_part_in_a_fit():
    regions = regions_of(make_joint(law="variable"), 3)
    law = regions.law
    reduced, dataset = fit_reduced_joint(regions, 4)
    for region in range(3):
        mine = (law.point_of_element == region) & (law.normal_load > 0)
        assert np.any((law.point_of_element == region) & ~mine)
        fit = fit_elements(law.tangential_stiffness[mine], law.slip_force[mine], 4)
        fitted = reduced.law.point_of_element == region
        np.testing.assert_array_equal(
            reduced.law.tangential_stiffness[fitted], fit.tangential_stiffness
        )
        np.testing.assert_allclose(reduced.law.slip_force[fitted], fit.slip_force, rtol=1e-14)
        assert dataset["fit_cost"][region] == fit.cost
    assert np.all(reduced.law.normal_load > 0)


def test_fitted_elements_keep_the_ratios_of_stiffness_and_of_friction():
    joint = make_joint(law="variable")
    equal = replace(joint.law, normal_stiffness=joint.law.tangential_stiffness)
    reduced, _ = fit_reduced_joint(regions_of(replace(joint, law=equal), 3), 4)
    law = reduced.law
    np.testing.assert_allclose(law.normal_stiffness, law.tangential_stiffness, rtol=1e-14)
    np.testing.assert_allclose(law.friction_coefficient, FRICTION, rtol=1e-14)
    np.testing.assert_allclose(law.normal_load, law.slip_force / FRICTION, rtol=1e-14)
    # that of the joint is 2
    law = fit_reduced_joint(regions_of(joint, 3), 4)[0].law
    np.testing.assert_allclose(law.normal_stiffness, 2 * law.tangential_stiffness, rtol=1e-14)


def test_a_region_of_fewer_elements_than_are_asked_for_is_named():
    few = merge_points(make_joint(), np.repeat([0, 1], [57, 3]))
    fit_reduced_joint(few, 3)
    with pytest.raises(ValueError, match="cannot fit 4 elements to region 2, which has 3 under lo"):
        fit_reduced_joint(few, 4)


def test_open_elements_do_not_make_a_region_large_enough():
    joint = make_joint(law="variable")
    load = joint.law.normal_load.copy()
    load[2:20] = -1.0
    opened = replace(joint, law=replace(joint.law, normal_load=load))
    regions = merge_points(opened, np.repeat([0, 1], [20, 40]))
    with pytest.raises(ValueError, match="to region 1, which has 2 under load: ask for fewer"):
        fit_reduced_joint(regions, 3)


def test_a_region_of_open_elements_has_none_after_the_fit():
    joint = make_joint(law="variable")
    load = joint.law.normal_load.copy()
    load[:20] = -1.0
    opened = replace(joint, law=replace(joint.law, normal_load=load))
    regions = merge_points(opened, np.repeat([0, 1, 2], 20))
    reduced, dataset = fit_reduced_joint(regions, 3)
    np.testing.assert_array_equal(reduced.law.point_of_element, np.repeat([1, 2], 3))
    assert reduced.points == 3
    alone = fit_reduced_joint(merge_points(joint, np.repeat([0, 1, 2], 20)), 3)[0].law
    np.testing.assert_array_equal(reduced.law.slip_force, alone.slip_force[3:])
    np.testing.assert_array_equal(np.isnan(dataset["rms_loop_error"]), [True, False, False])
    assert np.isfinite(dataset["loop_force_of_fit"][1:]).all()


@pytest.mark.parametrize("method", ["loops", "describing-function"])
def test_dataset_of_a_fit_has_its_loop_errors(method):
    regions = regions_of(make_joint(), 3)
    reduced, dataset = fit_reduced_joint(regions, 4, method=method)
    for point in range(3):
        of = [law.point_of_element == point for law in (regions.law, reduced.law)]
        elements = [
            values[mine]
            for law, mine in zip((regions.law, reduced.law), of, strict=True)
            for values in (law.tangential_stiffness, law.slip_force)
        ]
        error = loop_error(*elements)
        assert dataset["largest_loop_error"][point] == error.largest
        assert dataset["rms_loop_error"][point] == error.rms
        fit = fit_elements(*elements[:2], 4, method=method)
        np.testing.assert_array_equal(elements[2], fit.tangential_stiffness)
