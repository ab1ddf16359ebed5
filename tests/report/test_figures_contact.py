import numpy as np
import pytest
from figure_parts import FORCES, on_pairs, polygon_area, shapes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from scipy.spatial.transform import Rotation
from small_joint import make_joint
from text_boxes import faults

from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.friction import contact_states
from boltjoint.joint.derived import merge_points
from boltjoint.joint.io import joint_to_dataset
from boltjoint.report.figures.contact import (
    _STATES,
    plot_contact,
    plot_states,
    plot_weighted_pairs,
)
from boltjoint.report.figures.outlines import ContactSurface
from boltjoint.report.figures.regions import plot_regions


def state_areas(axes):
    """Area [mm2] drawn for each colour."""
    return {
        tuple(c.get_facecolor()[0]): polygon_area(c.get_paths()[0].to_polygons())
        for c in shapes(axes)
    }


def test_every_pair_is_drawn_as_its_area(assembly, preload):
    figure = plot_contact(assembly, preload)
    pressure, load, gap, _ = figure.axes[:4]
    loaded = preload["normal_load"].to_numpy() > 0
    for axes, shown in ((pressure, loaded), (load, loaded), (gap, ~loaded)):
        rest, cells = shapes(axes)
        assert len(cells.get_paths()) == shown.sum()
        drawn = [polygon_area(path.to_polygons()) for path in cells.get_paths()]
        # on a grid of rectangles the shares are those of the shape functions; mm2 from m2
        np.testing.assert_allclose(drawn, assembly["area"].to_numpy()[shown] * 1e6)
        whole = polygon_area(rest.get_paths()[0].to_polygons()) + sum(drawn)
        assert whole == pytest.approx(60 * 20)
    labels = {axes.get_ylabel() for axes in figure.axes}
    assert {"pressure (MPa)", "normal load (N)", "gap (μm)", "y (mm)"} <= labels


def test_points_without_a_mesh_are_squares_of_their_areas(assembly, preload):
    """Those of two surfaces are drawn one above the other."""
    pairs = assembly.sizes["pair"]
    frame = np.broadcast_to(np.eye(3), (pairs, 3, 3))
    names = np.where(np.arange(pairs) % 2, "upper", "lower").astype(object)
    points = assembly[["position", "area"]].assign(
        frame=(("pair", "direction", "axis"), frame), surface=("pair", names)
    )
    points = points.assign_coords(direction=["t1", "t2", "n"])
    figure = plot_contact(points, preload)
    _, cells = shapes(figure.axes[0])
    loaded = preload["normal_load"].to_numpy() > 0
    drawn = [polygon_area(path.to_polygons()) for path in cells.get_paths()]
    np.testing.assert_allclose(drawn, 1e6 * assembly["area"].to_numpy()[loaded])
    middle = np.array([path.vertices[:4].mean(axis=0) for path in cells.get_paths()])
    of_upper = names[loaded] == "upper"
    assert middle[of_upper, 1].min() > middle[~of_upper, 1].max()
    # the profile shows all of them
    assert sum(len(line.get_xydata()) for line in figure.axes[3].get_lines()) == pairs
    assert figure.axes[3].get_title(loc="left") == "all contact points"
    assert figure.axes[3].get_xlabel() == "along the first tangent (mm)"


def test_loads_along_the_middle_are_those_of_the_pairs(assembly, preload):
    axes = plot_contact(assembly, preload).axes[3]
    drawn = np.concatenate([line.get_xydata() for line in axes.get_lines()])
    middle = np.arange(1, 21, 3)
    x = assembly["position"].sel(axis="x").to_numpy() * 1e3
    expected = np.c_[x, preload["normal_load"].to_numpy()][middle]
    np.testing.assert_allclose(drawn[np.argsort(drawn[:, 0])], expected)
    (line,) = [c for c in axes.collections if isinstance(c, LineCollection)]
    assert len(line.get_segments()) == 6


def test_a_turned_surface_is_seen_in_its_plane(assembly):
    R = Rotation.from_euler("xyz", [0.7, -1.1, 2.3]).as_matrix()
    turned = assembly.copy()
    for name in ("position", "coordinate"):
        values = assembly[name].transpose(..., "axis")
        turned[name] = (values.dims, values.to_numpy() @ R.T)
    frame = np.broadcast_to(R.T, (assembly.sizes["pair"], 3, 3))
    turned["frame"] = (("pair", "direction", "axis"), frame)
    rest, found = (ContactSurface.of(each) for each in (assembly, turned))
    np.testing.assert_allclose(
        found.corner - found.corner[0], rest.corner - rest.corner[0], rtol=0, atol=1e-9
    )
    for name in ("share", "owner"):
        np.testing.assert_array_equal(getattr(found, name), getattr(rest, name))
    np.testing.assert_array_equal(found.edges_along_middle(), rest.edges_along_middle())


@pytest.mark.parametrize("load", [0.0, 10.0])
def test_a_contact_may_be_all_open_or_all_closed(assembly, preload, load):
    one = preload.assign(normal_load=0 * preload["normal_load"] + load, gap=0 * preload["gap"])
    figure = plot_contact(assembly, one)
    counts = [len(shapes(axes)[1].get_paths()) for axes in figure.axes[:3]]
    assert counts == ([21, 21, 0] if load else [0, 0, 21])


def test_assembly_and_preload_must_belong_together(assembly, preload):
    moved = preload.assign(position=preload["position"] + 1e-3)
    with pytest.raises(ValueError, match="different contact pairs"):
        plot_contact(assembly, moved)


def test_regions_show_their_place_their_elements_and_their_share(assembly):
    plan, bars = plot_regions(assembly, on_pairs(assembly, np.arange(15))).axes
    unused, *drawn = [polygon_area(c.get_paths()[0].to_polygons()) for c in shapes(plan)]
    area = assembly["area"].to_numpy() * 1e6
    assert [unused, *drawn] == pytest.approx([area[15:].sum(), area[:9].sum(), area[9:15].sum()])
    assert [bar.get_height() for bar in bars.patches] == pytest.approx([37.5, 62.5])
    assert [text.get_text() for text in bars.texts] == ["9\n37.5 %", "6\n62.5 %"]
    assert [text.get_text() for text in plan.texts] == ["1", "2"]
    assert "(%)" in bars.get_ylabel()
    assert bars.get_xlabel() == "x (mm)"


def test_weighted_pairs_have_the_colour_of_their_weight(assembly):
    joint = on_pairs(assembly, np.array([2, 5, 11]))[["element_position"]].assign(
        weight=("point", [1.0, 4.0, 16.0]), point_of_element=("element", [0, 1, 2])
    )
    plan, scale = plot_weighted_pairs(assembly, joint).axes
    unused, cells = shapes(plan)
    area = assembly["area"].to_numpy() * 1e6
    drawn = [polygon_area(path.to_polygons()) for path in cells.get_paths()]
    assert drawn == pytest.approx(area[[2, 5, 11]])
    rest = polygon_area(unused.get_paths()[0].to_polygons())
    assert rest == pytest.approx(area.sum() - area[[2, 5, 11]].sum())
    brightness = cells.get_facecolors()[:, :3].sum(axis=1)
    assert np.all(np.diff(brightness) < 0)
    assert scale.get_ylim() == pytest.approx((1.0, 16.0))
    assert "3 of 21 pairs" in plan.get_title() and plan.get_xlabel() == "x (mm)"


def test_weights_within_a_decade_and_more_have_labels_apart(assembly):
    pairs = on_pairs(assembly, np.array([2, 5, 11]))[["element_position"]]
    for largest in (1.5, 30.0, 800.0):
        joint = pairs.assign(
            weight=("point", [1.0, 1.2, largest]), point_of_element=("element", [0, 1, 2])
        )
        assert not faults(plot_weighted_pairs(assembly, joint))


def test_regions_under_variable_load_tell_open_pairs_from_loaded_ones(assembly, variable):
    region = np.repeat([0, 1], [9, 12])
    joint = joint_to_dataset(merge_points(variable, region))
    plan, bars, profile = plot_regions(assembly, joint).axes
    load = np.maximum(variable.law.normal_load, 0)
    area = assembly["area"].to_numpy()
    *_, pale = [polygon_area(c.get_paths()[0].to_polygons()) for c in shapes(plan)]
    assert pale == pytest.approx(1e6 * area[load == 0].sum())
    loaded = np.bincount(region, load > 0).astype(int)
    share = 100 * np.bincount(region, load) / load.sum()
    assert 0 < loaded.sum() < 21
    assert [text.get_text() for text in bars.texts] == [
        f"{loaded[0]} of 9\n{share[0]:.1f} %",
        f"{loaded[1]} of 12\n{share[1]:.1f} %",
    ]
    middle = np.arange(1, 21, 3)
    pressure = load[middle] / area[middle] / 1e6
    drawn = np.concatenate([line.get_xydata() for line in profile.get_lines()])
    x = assembly["position"].sel(axis="x").to_numpy()[middle] * 1e3
    np.testing.assert_allclose(drawn[np.argsort(drawn[:, 0])], np.c_[x, pressure])
    # the parts of the regions make up the profile
    parts = [c for c in profile.collections if not isinstance(c, LineCollection)]
    areas = [abs(polygon_area(c.get_paths()[0].to_polygons())) for c in parts]
    assert len(areas) == 2
    assert sum(areas) == pytest.approx(np.trapezoid(pressure, x))
    assert profile.get_ylabel() == "pressure (MPa)"


def test_regions_must_lie_on_the_assembly(assembly):
    joint = on_pairs(assembly, np.arange(15))
    moved = joint.assign(element_position=joint["element_position"] + 1e-4)
    with pytest.raises(ValueError, match="15 elements lie on no contact pair"):
        plot_regions(assembly, moved)


def test_every_pair_has_the_colour_of_its_state(assembly, variable, variable_response):
    joint = joint_to_dataset(variable)
    figure = plot_states(assembly, joint, variable_response)
    panels = [axes for axes in figure.axes if axes.get_title(loc="left")]
    colours = [to_rgba(colour) for colour in _STATES]
    area = assembly["area"].to_numpy() * 1e6
    found = variable_response["contact_state"].to_numpy()
    assert len(panels) == len(FORCES)
    for level, axes in enumerate(panels):
        drawn = state_areas(axes)
        expected = [area[found[level] == number].sum() for number in range(4)]
        assert [drawn[colour] for colour in colours] == pytest.approx(expected)
        frequency = variable_response["peak_frequency"][level].item()
        assert axes.get_title(loc="left") == f"{FORCES[level]:g} N, {frequency:.1f} Hz"
        shares = [text.get_text() for text in axes.get_legend().get_texts()]
        some = np.unique(found[level], return_counts=True)[1] / 21
        assert shares == [f"{100 * share:.0f} %" for share in some]
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == [contact_states.MEANINGS[number] for number in np.unique(found)]


def test_pairs_without_element_and_levels_without_peak_are_told_apart(assembly):
    joint = on_pairs(assembly, np.arange(15))
    nodes = make_joint(15)
    solved = solve_response(nodes, [0.01, 5.0], damping=0.01)
    solved["contact_state"][1] = contact_states.UNKNOWN
    solved["peak_frequency"][1] = np.nan
    figure = plot_states(assembly, joint, solved)
    for axes in figure.axes:
        assert state_areas(axes)[to_rgba("0.87")] == pytest.approx(300)
    assert figure.axes[1].get_title(loc="left") == "5 N: no peak found"
    assert figure.axes[1].get_legend() is None
    (unknown,) = [c for c in shapes(figure.axes[1]) if c.get_hatch()][-1:]
    assert polygon_area(unknown.get_paths()[0].to_polygons()) == pytest.approx(900)
    assert figure.legends[0].get_texts()[-1].get_text() == "no element"


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_states_of_any_number_of_levels(assembly, variable, variable_response, levels):
    some = variable_response.isel(force=slice(levels))
    figure = plot_states(assembly, joint_to_dataset(variable), some)
    assert sum(bool(axes.get_title(loc="left")) for axes in figure.axes) == levels


def test_states_need_the_joint_that_was_solved(assembly, variable, response):
    with pytest.raises(ValueError, match="the joint has 21 elements, the response 60"):
        plot_states(assembly, joint_to_dataset(variable), response)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_slip_forces_in_a_file_are_those_of_the_law(law):
    joint = make_joint(law=law)
    np.testing.assert_array_equal(joint_to_dataset(joint)["slip_force"], joint.law.slip_force)
