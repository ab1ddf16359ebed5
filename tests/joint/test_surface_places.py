"""Places of contact points in the planes of their surfaces, and regions of several surfaces."""

from dataclasses import replace

import numpy as np
import pytest
from joint_examples import grid
from scipy.spatial.transform import Rotation
from small_joint import make_joint, make_preload

from boltjoint.joint.bands import bands_of_equal_load, on_each_surface
from boltjoint.joint.clusters import cluster_by_motion
from boltjoint.joint.derived import merge_points
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.joint.model import keep_elements
from boltjoint.joint.partition import choose_count, partition_regions
from boltjoint.joint.surface_places import SurfacePlaces

TURN = Rotation.from_euler("xyz", [0.3, 1.2, -2.0]).as_matrix()
#: surface of each of the 60 points of ``make_joint``
TWO = np.array(["lap"] * 45 + ["flange"] * 15)


def on_two_surfaces(law="constant"):
    """The joint and its preload with the last quarter of the pairs on another surface."""
    joint = make_joint(law=law)
    preload = make_preload(joint)
    preload["surface"] = ("pair", TWO.astype(object))
    return replace(joint, places=SurfacePlaces.of("preload", preload)), preload


def test_places_of_a_turned_plane_are_those_of_the_plane():
    plan = grid(np.linspace(0.1, 0.3, 5), np.linspace(-0.02, 0.02, 3))
    position = np.column_stack([plan, np.zeros(len(plan))]) @ TURN.T + [1.0, 2.0, 3.0]
    frame = np.broadcast_to(TURN.T, (len(plan), 3, 3))
    found = SurfacePlaces.in_planes(position, frame, np.full(len(plan), "lap")).place
    np.testing.assert_allclose(found - found[7], plan - plan[7], rtol=0, atol=1e-14)
    # across it from the middle
    np.testing.assert_allclose(found[:, 1], plan[:, 1], rtol=0, atol=1e-14)


def test_a_level_surface_has_its_x_and_y_to_the_bit():
    joint, preload = make_joint(), make_preload(make_joint())
    edges = np.array([[0.05, -0.01, 0.0], [0.05, 0.01, 0.0]])
    preload["position"][:2] = edges
    place = SurfacePlaces.of("preload", preload).place
    np.testing.assert_array_equal(place[:2], edges[:, :2])
    np.testing.assert_array_equal(place[2:], joint.position[2:, :2])


def test_surfaces_have_planes_of_their_own():
    plan = grid(np.linspace(0.0, 0.1, 4), np.linspace(-0.01, 0.01, 3))
    flat = np.column_stack([plan, np.zeros(len(plan))])
    position = np.concatenate([flat, flat @ TURN.T + 0.5])
    frame = np.repeat([np.eye(3), TURN.T], len(plan), axis=0)
    name = np.repeat(["flange", "lap"], len(plan))
    found = SurfacePlaces.in_planes(position, frame, name)
    np.testing.assert_array_equal(found.number, np.repeat([0, 1], len(plan)))
    for surface in (found.place[: len(plan)], found.place[len(plan) :]):
        np.testing.assert_allclose(surface - surface[0], plan - plan[0], rtol=0, atol=1e-14)


def test_tangents_around_a_ring_have_no_mean_and_still_a_plane():
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    radial = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    normal = np.broadcast_to([0.0, 0.0, 1.0], radial.shape)
    frame = np.stack([radial, np.cross(normal, radial), normal], axis=1)
    place = SurfacePlaces.in_planes(0.1 * radial, frame, np.full(12, "ring")).place
    np.testing.assert_allclose(np.hypot(*place.T), 0.1, rtol=1e-12)


@pytest.mark.parametrize("law", ["constant", "variable"])
@pytest.mark.parametrize("division", ["equal-load", "equal-middle-load", "inner-outer", "clusters"])
def test_a_region_lies_on_one_surface(division, law):
    joint, preload = on_two_surfaces(law)
    if division == "equal-middle-load":
        preload["position"][:, 1] = 0.0
        joint = replace(joint, position=preload["position"].to_numpy())
    found = partition_regions(joint, preload, 8, division)
    region = found.law.point_of_element
    assert np.unique(region).size == 8
    for each in range(8):
        assert np.unique(TWO[region == each]).size == 1
    # surfaces in the order of their names
    assert found.places.name[0] == "flange"
    assert found.places.name[-1] == "lap"
    with pytest.raises(ValueError, match=r"1 regions (do not lie on 2 surfaces|are not)"):
        partition_regions(joint, preload, 1, division)


def test_numbers_of_regions_follow_the_loads_of_the_surfaces():
    joint, preload = on_two_surfaces()
    share = joint.law.slip_force[TWO == "flange"].sum() / joint.law.slip_force.sum()
    region = partition_regions(joint, preload, 20).law.point_of_element
    on_flange = np.unique(region[TWO == "flange"]).size
    assert abs(on_flange - 20 * share) < 1
    # and so do the loads of the bands: a mesh of 60 pairs divides into 10 only roughly
    load = np.bincount(region, joint.law.slip_force)
    assert load.max() < 2.5 * load.mean()


@pytest.mark.parametrize("law", ["constant", "variable"])
@pytest.mark.parametrize("division", ["equal-load", "equal-middle-load", "inner-outer"])
def test_numbers_of_regions_follow_slip_forces_where_friction_differs(division, law):
    joint, preload = on_two_surfaces(law)
    if division == "equal-middle-load":
        # all on the middle, evenly
        preload["position"][:, 0], preload["position"][:, 1] = np.arange(60.0), 0.0
        preload["normal_load"][:] = preload["area"]
        joint = replace(joint, position=preload["position"].to_numpy())
    # a fifth of the friction on one surface, under the same loads
    less = {"friction_coefficient": np.where(TWO == "lap", 0.02, 0.1)}
    if law == "constant":
        less = {"slip_force": joint.law.slip_force * np.where(TWO == "lap", 0.2, 1.0)}
    mixed = replace(joint, law=replace(joint.law, **less))
    regions = (partition_regions(each, preload, 8, division) for each in (joint, mixed))
    one, other = (np.unique(each.law.point_of_element[TWO == "lap"]).size for each in regions)
    slip = [each.law.slip_force for each in (joint, mixed)]
    expected = [8 * each[TWO == "lap"].sum() / each.sum() for each in slip]
    multiple = 2 if division == "inner-outer" else 1
    assert other < one
    np.testing.assert_allclose([one, other], expected, rtol=0, atol=multiple)


def test_surfaces_of_equal_loads_have_regions_whatever_the_rounding():
    surface, x = np.repeat([0, 1], 12), np.tile(np.arange(12.0), 2)
    position, load = np.column_stack([x, 0 * x]), np.ones(24)
    for noise in (-1e-12, 0.0, 1e-12):
        region = on_each_surface(
            bands_of_equal_load, surface, position, load * (1 + noise * surface), 5
        )
        assert np.unique(region[surface == 0]).size == 3


def test_clusters_of_pairs_that_move_alike_are_told_apart_by_their_surface():
    joint, _ = on_two_surfaces()
    alike = replace(joint, tangential_mode=np.ones_like(joint.tangential_mode))
    region = cluster_by_motion(alike, 2)
    np.testing.assert_array_equal(region, TWO == "lap")


def test_a_region_across_surfaces_is_refused():
    joint, _ = on_two_surfaces()
    with pytest.raises(ValueError, match="region 0 has points of lap and of flange"):
        merge_points(joint, np.zeros(60, dtype=int))


def test_the_fewest_regions_within_a_tolerance_are_on_all_surfaces():
    joint, preload = on_two_surfaces()
    assert choose_count(joint, preload, 10.0) == 2


def test_surfaces_of_other_dimensions_are_refused():
    joint, preload = on_two_surfaces()
    with pytest.raises(
        ValueError, match=r"surface of preload is over \(point\), expected \(pair\)"
    ):
        partition_regions(joint, preload.assign(surface=("point", ["lap"])), 4)
    stored = joint_to_dataset(joint)
    with pytest.raises(ValueError, match=r"surface of stored is over \(mode\), expected \(point\)"):
        joint_from_dataset(stored.assign(surface=("mode", ["lap"] * 3)))


def test_places_are_kept_in_files_and_with_points():
    joint, _ = on_two_surfaces()
    stored = joint_from_dataset(joint_to_dataset(joint))
    few = keep_elements(joint, 1.0 * (np.arange(60) % 7 == 0))
    for found, points in ((stored, np.arange(60)), (few, np.arange(0, 60, 7))):
        np.testing.assert_array_equal(found.places.name, TWO[points])
        np.testing.assert_array_equal(found.places.place, joint.places.place[points])
    one = make_joint()
    assert "place" not in joint_to_dataset(one)
    np.testing.assert_array_equal(one.surface_places.place, one.position[:, :2])
