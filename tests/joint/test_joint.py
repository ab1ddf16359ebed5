from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from small_joint import make_joint

from boltjoint import dataset
from boltjoint.friction.contact_states import SEPARATION, STICK_SLIP_SEPARATION
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset, load_joint
from boltjoint.joint.model import merge_points
from boltjoint.joint.node_to_node import connect_nodes


@pytest.fixture(params=["constant", "variable"])
def either(request):
    """A joint of each law."""
    return make_joint(law=request.param)


def modes_and_preload():
    position = np.column_stack([np.linspace(0, 0.1, 5), np.zeros(5), np.zeros(5)])
    random = np.random.default_rng(0)
    modes = xr.Dataset(
        {
            "natural_frequency": ("mode", [70.0, 360.0]),
            "relative_mode": (("pair", "axis", "mode"), random.normal(size=(5, 3, 2))),
            "response_mode": ("mode", [1.0, -1.0]),
            "excitation_mode": ("mode", [1.1, -0.9]),
            "position": (("pair", "axis"), position),
        },
        coords={"axis": ["x", "y", "z"]},
    )
    preload = xr.Dataset(
        {
            "normal_load": ("pair", [10.0, 0.0, 30.0, 0.0, 20.0]),
            "gap": ("pair", [0.0, 2e-7, 0.0, 5e-8, 0.0]),
            "position": (("pair", "axis"), position),
        },
        coords={"axis": ["x", "y", "z"]},
    )
    return modes, preload


def test_only_loaded_pairs_get_an_element():
    modes, preload = modes_and_preload()
    joint = connect_nodes(modes, preload, 1e8, 0.1)
    np.testing.assert_allclose(joint.law.slip_force, [1.0, 3.0, 2.0])
    np.testing.assert_array_equal(joint.law.tangential_stiffness, 1e8)
    along_bar = modes["relative_mode"].sel(axis="x").to_numpy()
    np.testing.assert_array_equal(joint.tangential_mode, along_bar[[0, 2, 4]])
    np.testing.assert_array_equal(joint.element_position, modes["position"].to_numpy()[[0, 2, 4]])


def test_all_pairs_get_an_element_if_they_may_close():
    modes, preload = modes_and_preload()
    joint = connect_nodes(modes, preload, 1e8, 0.1, 3e8)
    law = joint.law
    assert isinstance(law, VariableLoad)
    np.testing.assert_array_equal(law.point_of_element, np.arange(5))
    np.testing.assert_array_equal(law.tangential_stiffness, 1e8)
    np.testing.assert_array_equal(law.normal_stiffness, 3e8)
    np.testing.assert_array_equal(law.friction_coefficient, 0.1)
    # -k_v gap where open: 3e8 N/m over 0.2 and 0.05 um
    np.testing.assert_allclose(law.normal_load, [10, -60, 30, -15, 20], rtol=1e-14)
    relative = modes["relative_mode"]
    np.testing.assert_array_equal(joint.tangential_mode, relative.sel(axis="x"))
    np.testing.assert_array_equal(joint.normal_mode, relative.sel(axis="z"))
    for position in (joint.position, joint.element_position):
        np.testing.assert_array_equal(position, modes["position"])


def test_a_pair_closes_where_the_lower_bar_moves_up_by_more_than_the_gap():
    modes, preload = modes_and_preload()
    # side A is the lower bar: its displacement along z less that of B
    modes["relative_mode"][:] = 0.0
    modes["relative_mode"].loc[{"axis": "z", "mode": 0}] = 1.0
    joint = connect_nodes(modes, preload, 1e8, 0.1, 3e8)
    open_by = preload["gap"].to_numpy()[1]

    def state_of_pair_1(rise):
        bias_of_modes = np.array([[rise, 0.0], [0.0, 0.0], [0.0, 0.0]])
        motion = np.hstack([B @ bias_of_modes.T for B in joint.rows])
        motion[:, 4] = 1e-3 * open_by
        return joint.law.contact_state(motion)[1]

    assert state_of_pair_1(0.99 * open_by) == SEPARATION
    assert state_of_pair_1(open_by) == STICK_SLIP_SEPARATION
    assert state_of_pair_1(-2 * open_by) == SEPARATION
    assert state_of_pair_1(1.01 * open_by) not in (SEPARATION, STICK_SLIP_SEPARATION)


def test_axes_of_files_may_be_in_any_order():
    modes, preload = modes_and_preload()
    joint = connect_nodes(modes, preload, 1e8, 0.1, 3e8)
    turned = connect_nodes(
        modes.transpose("mode", "axis", "pair"), preload.transpose("axis", "pair"), 1e8, 0.1, 3e8
    )
    for name in ("tangential_mode", "normal_mode", "position"):
        np.testing.assert_array_equal(getattr(turned, name), getattr(joint, name))


def test_modes_and_preload_of_different_meshes_are_refused():
    modes, preload = modes_and_preload()
    with pytest.raises(ValueError, match="different contact pairs"):
        connect_nodes(modes, preload.isel(pair=slice(1, None)), 1e8, 0.1)


@pytest.mark.parametrize("normal_stiffness", [None, 3e8])
def test_a_joint_without_load_is_refused(normal_stiffness):
    modes, preload = modes_and_preload()
    preload["normal_load"][:] = 0.0
    with pytest.raises(ValueError, match="no contact pair carries load"):
        connect_nodes(modes, preload, 1e8, 0.1, normal_stiffness)


def test_joint_survives_its_file(either, tmp_path):
    dataset.save(joint_to_dataset(either), tmp_path / "joint.nc")
    again = load_joint(tmp_path / "joint.nc")
    assert type(again.law) is type(either.law)
    for one, other in ((again, either), (again.law, either.law)):
        for name in vars(other):
            if name != "law":
                np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_axes_of_a_joint_file_may_be_in_any_order(either):
    stored = joint_to_dataset(either)
    again = joint_from_dataset(stored.transpose(*sorted(stored.dims)))
    for one, other in zip(again.rows, either.rows, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(again.position, either.position)


def test_every_quantity_of_a_joint_file_has_a_unit_and_a_meaning(either):
    stored = joint_to_dataset(either)
    assert set(either.law.quantities) < set(stored)
    for name in stored.data_vars:
        assert {"units", "long_name"} <= set(stored[name].attrs), name


def test_unknown_law_is_refused(joint):
    with pytest.raises(ValueError, match="'magic' is not known; allowed: constant, variable"):
        joint_from_dataset(joint_to_dataset(joint).assign_attrs(law="magic"))


def test_parts_that_do_not_fit_are_refused(joint):
    with pytest.raises(ValueError, match="tangential_mode has shape"):
        replace(joint, tangential_mode=joint.tangential_mode[:-1])
    with pytest.raises(ValueError, match="elements must sit on points"):
        replace(joint, law=replace(joint.law, point_of_element=joint.law.point_of_element + 1))


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
