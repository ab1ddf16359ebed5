"""The mesh: pairs, ties, cells, volume and named nodes, on a coarse assembly and the study's."""

from collections import Counter
from itertools import product

import numpy as np
import pytest
from examples import coarse_assembly
from scipy.spatial import KDTree

from boltjoint.dataset import save
from boltjoint.structure.elasticity import smallest_jacobian
from boltjoint.structure.extrusion.cell import BoltRadii, CellDivisions
from boltjoint.structure.extrusion.plan import tributary_area
from boltjoint.structure.makers.half_lap.mesh import FIRST_BOLT, build_assembly
from boltjoint.structure.makers.half_lap.plan import lap_plan


def volume(assembly):
    """Integral of the Jacobian over all hexahedra [m3]."""
    x = assembly["coordinate"].to_numpy()[assembly["connectivity"].to_numpy()]
    corner = np.array(list(product([-1, 1], repeat=3))) / np.sqrt(3)
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    parent = np.column_stack([np.tile(square, (2, 1)), np.repeat([-1, 1], 4)])
    total = 0.0
    for point in corner:
        factor = 1 + parent * point
        slope = np.stack([parent[:, a] * np.delete(factor, a, 1).prod(1) / 8 for a in range(3)])
        total += np.linalg.det(slope @ x).sum()
    return total


@pytest.mark.parametrize("across", [2, 6])
@pytest.mark.parametrize("rings", [(1, 1, 1), (2, 3, 2)])
@pytest.mark.parametrize("columns", [(1, 1), (3, 4)])
def test_number_of_pairs_is_known_beforehand(across, rings, columns):
    config = coarse_assembly(
        ring_cells_across_width=across,
        rings_under_head=rings[0],
        rings_head_to_cell_edge=rings[1],
        rings_in_shank=rings[2],
        columns_between_bolt_cells=columns[0],
        columns_at_each_lap_end=columns[1],
    )
    assert build_assembly(config).sizes["pair"] == config.contact_pairs


def test_study_assemblies_have_the_published_pairs(of_study):
    config, assembly = of_study
    published = {3: 1370, 4: 1693}
    assert assembly.sizes["pair"] == published[assembly.sizes["bolt"]] == config.contact_pairs


def test_pairs_coincide_and_are_in_order(assembly):
    position = assembly["coordinate"].to_numpy()[assembly["pair_node"].to_numpy()]
    np.testing.assert_array_equal(position[:, 0], position[:, 1])
    np.testing.assert_array_equal(position[:, 0], assembly["position"])
    assert not np.any(position[..., 2])
    key = [(round(x, 9), round(y, 9)) for x, y, _ in position[:, 0]]
    assert key == sorted(set(key))
    part_of_node = {side: set() for side in (0, 1)}
    for part in part_of_node:
        chosen = assembly["connectivity"].to_numpy()[assembly["part"] == part]
        part_of_node[part] = set(chosen.ravel().tolist())
    for side in (0, 1):
        assert set(assembly["pair_node"].to_numpy()[:, side].tolist()) <= part_of_node[side]


def test_all_cells_are_sound(of_study):
    _, assembly = of_study
    connectivity, coordinate = (
        assembly["connectivity"].to_numpy(),
        assembly["coordinate"].to_numpy(),
    )
    jacobian = smallest_jacobian(coordinate, connectivity)
    corner = coordinate[connectivity]
    edges = [corner[:, [1, 3, 4]] - corner[:, [0]], corner[:, [7, 5, 2]] - corner[:, [6]]]
    scaled = [abs(np.linalg.det(e / np.linalg.norm(e, axis=-1, keepdims=True))) for e in edges]
    assert jacobian.min() > 0
    # the sine of the sharpest angle: in the corners of the bolt cells
    assert np.min(scaled) > 0.5


def test_volume_is_that_of_the_drawing(of_study):
    config, assembly = of_study
    bar, bolts, n = config.bar, config.bolts, assembly.sizes["bolt"]

    def circle(diameter):
        return np.pi * diameter**2 / 4

    solid = bar.width_mm * bar.height_mm * bar.length_mm
    holes = n * circle(bolts.hole_diameter_mm) * bar.height_mm
    shanks = n * circle(bolts.shank_diameter_mm) * bar.height_mm
    heads = n * circle(bolts.head_diameter_mm) * (bolts.head_height_mm + bolts.nut_height_mm)
    # polygons have the area of their circle, so nothing but rounding remains
    exact = 1e-9 * (solid - holes + shanks + heads)
    assert volume(assembly) == pytest.approx(exact, rel=1e-12)


def test_tributary_areas_add_up_to_the_contact(of_study):
    config, assembly = of_study
    hole = np.pi * config.bolts.hole_diameter_mm**2 / 4
    contact = config.bar.width_mm * config.bar.lap_mm - assembly.sizes["bolt"] * hole
    assert assembly["area"].min() > 0
    assert float(assembly["area"].sum()) == pytest.approx(1e-6 * contact, rel=1e-12)


def test_only_the_intended_nodes_are_double(of_study):
    config, assembly = of_study
    coordinate = assembly["coordinate"].to_numpy()
    doubles = KDTree(coordinate).query_pairs(1e-7)
    intended = {
        tuple(sorted(pair))
        for name in ("pair_node", "section_node")
        for pair in assembly[name].to_numpy().tolist()
    }
    others = np.array(sorted(doubles - intended))
    # the ends of the bars stand before the shoulders of the other bar without touching them
    across = config.mesh.ring_cells_across_width + 1
    assert intended <= doubles
    assert len(others) == 2 * across * config.mesh.layers_per_half_height
    ends = 1e-3 * (config.bar.free_length_mm[0] + np.array([0, config.bar.lap_mm]))
    x, z = coordinate[others[:, 0], 0], coordinate[others[:, 0], 2]
    np.testing.assert_allclose(x, np.where(z > 0, *ends), atol=1e-12)


def test_cells_fit_face_to_face(assembly):
    faces = [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    face = np.sort(assembly["connectivity"].to_numpy()[:, faces].reshape(-1, 4), axis=1)
    owners = Counter(map(tuple, face.tolist()))
    assert set(owners.values()) == {1, 2}
    used = np.unique(assembly["connectivity"])
    np.testing.assert_array_equal(used, np.arange(assembly.sizes["node"]))


def test_head_and_nut_share_nodes_with_the_bars(assembly, coarse):
    connectivity, part = assembly["connectivity"].to_numpy(), assembly["part"].to_numpy()
    of_bars = np.unique(connectivity[part < FIRST_BOLT])
    around = 2 * (coarse.mesh.ring_cells_across_width + coarse.mesh.ring_cells_along_bar)
    for bolt in range(assembly.sizes["bolt"]):
        tied = np.intersect1d(of_bars, connectivity[part == FIRST_BOLT + bolt])
        x, y, z = (
            assembly["coordinate"].to_numpy()[tied] - assembly["bolt_position"][bolt].values
        ).T
        assert len(tied) == 2 * around * (coarse.mesh.rings_under_head + 1)
        np.testing.assert_allclose(abs(z), 0.01, rtol=1e-12)
        # radii of polygons of the area of the circle are a little larger than its radius
        assert 4.5e-3 < np.hypot(x, y).min() < np.hypot(x, y).max() < 6.7e-3


def test_mesh_is_symmetric_about_the_width(assembly):
    coordinate = assembly["coordinate"].to_numpy()
    distance, _ = KDTree(coordinate).query(coordinate * [1, -1, 1])
    assert distance.max() < 1e-12


def test_named_nodes(assembly, coarse):
    coordinate = assembly["coordinate"].to_numpy()
    clamped = coordinate[assembly["clamped_node"].to_numpy()]
    assert not clamped[:, 0].any()
    assert len(clamped) == np.sum(coordinate[:, 0] < 1e-9)
    for name in ("excitation_node", "response_node"):
        assert assembly[name].attrs["direction"] == "z"
        np.testing.assert_allclose(
            coordinate[assembly[name].item()], [1e-3 * coarse.bar.length_mm, 0, 0.01], atol=1e-12
        )
    section = coordinate[assembly["section_node"].to_numpy()]
    np.testing.assert_array_equal(section[:, 0], section[:, 1])
    axis = assembly["bolt_position"].to_numpy()[assembly["section_bolt"].to_numpy()]
    assert np.linalg.norm(section[:, 0] - axis, axis=1).max() < 4.1e-3


def test_every_variable_has_units(assembly, tmp_path):
    save(assembly, tmp_path / "assembly.nc")


def test_refuses_an_odd_number_of_cells_across(coarse):
    odd = coarse.mesh.model_copy(update={"ring_cells_across_width": 5})
    with pytest.raises(ValueError, match="must be even"):
        build_assembly(coarse.model_copy(update={"mesh": odd}))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"axes": [0.02, 0.04]}, "overlap, touch or leave the lap"),
        ({"axes": [0.01, 0.05]}, "overlap, touch or leave the lap"),
        ({"axes": [0.02, 0.06]}, "overlap, touch or leave the lap"),
        ({"width": 0.012}, "does not fit into a bolt cell"),
        ({"cell_length": 0.012}, "does not fit into a bolt cell"),
    ],
)
def test_refuses_bolts_that_do_not_fit(change, message):
    fitting = {
        "axes": [0.019, 0.049],
        "length": 0.07,
        "width": 0.02,
        "cell_length": 0.022,
        "radii": BoltRadii(0.004, 0.0045, 0.0065),
        "divisions": CellDivisions(4, 5, 1, 1, 2),
        "columns_between": 2,
        "columns_at_ends": 3,
    }
    assert tributary_area(lap_plan(**fitting).plan).min() > 0
    with pytest.raises(ValueError, match=message):
        lap_plan(**{**fitting, **change})
