from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from small_joint import make_joint

from boltjoint import dataset
from boltjoint.joint import connect_nodes, from_dataset, merge_points, to_dataset
from boltjoint.partition import partition_regions, regions_of_equal_load


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


def test_modes_and_preload_of_different_meshes_are_refused():
    modes, preload = modes_and_preload()
    with pytest.raises(ValueError, match="different contact pairs"):
        connect_nodes(modes, preload.isel(pair=slice(1, None)), 1e8, 0.1)


def test_a_joint_without_load_is_refused():
    modes, preload = modes_and_preload()
    with pytest.raises(ValueError, match="no contact pair carries load"):
        connect_nodes(modes, preload.assign(normal_load=preload["normal_load"] * 0), 1e8, 0.1)


def test_joint_survives_its_file(joint, tmp_path):
    dataset.save(to_dataset(joint), tmp_path / "joint.nc")
    again = from_dataset(dataset.load(tmp_path / "joint.nc"))
    for name in ("natural_frequency", "tangential_mode", "position", "element_position"):
        np.testing.assert_array_equal(getattr(again, name), getattr(joint, name))
    np.testing.assert_array_equal(again.law.slip_force, joint.law.slip_force)


def test_unknown_law_is_refused(joint):
    with pytest.raises(ValueError, match="law 'magic' is not known; allowed: constant"):
        from_dataset(to_dataset(joint).assign_attrs(law="magic"))


def test_parts_that_do_not_fit_are_refused(joint):
    with pytest.raises(ValueError, match="tangential_mode has shape"):
        replace(joint, tangential_mode=joint.tangential_mode[:-1])
    with pytest.raises(ValueError, match="elements must sit on points"):
        replace(joint, law=replace(joint.law, point_of_element=joint.law.point_of_element + 1))


def test_stuck_stiffness_is_that_of_the_springs(joint):
    R, k = joint.tangential_mode, joint.law.tangential_stiffness
    np.testing.assert_allclose(joint.stuck_stiffness(), R.T @ np.diag(k) @ R)


def test_regions_of_one_pair_each_are_the_node_to_node_joint(joint):
    regions = merge_points(joint, np.arange(joint.points))
    np.testing.assert_array_equal(regions.tangential_mode, joint.tangential_mode)
    np.testing.assert_array_equal(regions.law.point_of_element, joint.law.point_of_element)


def test_a_region_moves_as_the_mean_of_its_pairs(joint):
    regions = merge_points(joint, np.repeat([0, 1], [20, 40]))
    np.testing.assert_allclose(regions.tangential_mode[0], joint.tangential_mode[:20].mean(axis=0))
    np.testing.assert_allclose(regions.position[1], joint.position[20:].mean(axis=0))
    assert regions.law.slip_force is joint.law.slip_force


def test_regions_must_count_without_gaps(joint):
    with pytest.raises(ValueError, match="without gaps"):
        merge_points(joint, np.repeat([0, 2], [20, 40]))


def test_regions_carry_equal_load_in_order_along_the_bar():
    joint = make_joint(pairs=2000)
    x, load = joint.position[:, 0], joint.law.slip_force
    region = regions_of_equal_load(joint.position[:, :2], load, 6)
    share = np.bincount(region, load) / load.sum()
    # a region cannot be divided finer than a pair
    np.testing.assert_allclose(share, 1 / 6, atol=2 * load.max() / load.sum())
    assert np.all(np.diff(region[np.argsort(x)]) >= 0)


def test_regions_do_not_depend_on_the_order_of_pairs(joint):
    position, load = joint.position[:, :2], joint.law.slip_force
    shuffled = np.random.default_rng(0).permutation(load.size)
    np.testing.assert_array_equal(
        regions_of_equal_load(position, load, 4)[shuffled],
        regions_of_equal_load(position[shuffled], load[shuffled], 4),
    )


def test_pairs_that_mirror_each_other_stay_together():
    x = np.repeat(np.arange(5.0), 4) + np.tile([0, 1e-12, -1e-12, 2e-12], 5)
    y = np.tile([-0.02, -0.01, 0.01, 0.02], 5) + np.tile([0, 1e-12], 10)
    region = regions_of_equal_load(np.column_stack([x, y]), np.ones(20), 2)
    np.testing.assert_array_equal(np.bincount(region), [10, 10])
    for i in range(5):
        of_column = region[4 * i : 4 * i + 4]
        assert of_column[0] == of_column[3]
        assert of_column[1] == of_column[2]


def test_a_pair_with_most_of_the_load_leaves_no_region_empty():
    position = np.column_stack([np.arange(8.0), np.zeros(8)])
    load = np.array([1.0, 1, 100, 1, 1, 1, 1, 1])
    for count in range(1, 9):
        region = regions_of_equal_load(position, load, count)
        np.testing.assert_array_equal(np.unique(region), np.arange(count))
        assert np.all(np.diff(region) >= 0)


def test_too_many_regions_are_refused(joint):
    with pytest.raises(ValueError, match="do not divide into 61 regions"):
        partition_regions(joint, 61)
