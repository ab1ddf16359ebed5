import re
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_rgba
from small_joint import make_joint, make_preload
from small_study import ASSEMBLY

from boltjoint import dataset
from boltjoint.config.assembly import Assembly
from boltjoint.dynamics.epmc import find_backbone
from boltjoint.dynamics.frequency_response import frequency_window, solve_response
from boltjoint.friction import contact_states
from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.masing import loading_curve
from boltjoint.joint.model import merge_points
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import fit_reduced_joint
from boltjoint.report.figures.contact import _STATES, plot_contact, plot_regions, plot_states
from boltjoint.report.figures.convergence import (
    plot_bases,
    plot_divisions,
    plot_models,
    plot_patterns,
    plot_sampling,
)
from boltjoint.report.figures.drawing import _VIEW
from boltjoint.report.figures.loops import plot_loops
from boltjoint.report.figures.responses import plot_backbones, plot_response
from boltjoint.report.figures.structure import plot_deformation, plot_mesh, plot_modes
from boltjoint.report.figures.style import save_figure
from boltjoint.report.figures.times import plot_times
from boltjoint.solvers.equations import StepControl
from boltjoint.structure.half_lap.mesh import build_assembly

FORCES = [0.01, 5.0, 20.0]
HEIGHT = 0.01
BOLTED = ASSEMBLY | {
    "bar": {"width_mm": 20, "height_mm": 16, "free_length_mm": [60, 50], "lap_mm": 62},
    "material": {"youngs_modulus_GPa": 200, "poissons_ratio": 0.3, "density_kg_per_m3": 7800},
}


@pytest.fixture(scope="module")
def assembly():
    """Two plates of 6 x 2 elements on each other, in contact all over."""
    plan = np.stack(np.meshgrid(np.linspace(0, 0.06, 7), [-0.01, 0, 0.01], indexing="ij"), -1)
    plan = plan.reshape(-1, 2)
    quad = np.array(
        [[3 * i + j, 3 * i + 3 + j, 3 * i + 4 + j, 3 * i + 1 + j] for i in range(6) for j in (0, 1)]
    )
    levels = (-HEIGHT, 0, 0, HEIGHT)
    coordinate = np.concatenate([np.c_[plan, np.full(21, z)] for z in levels])
    bar_a, bar_b = (np.c_[quad + 42 * bar, quad + 42 * bar + 21] for bar in (0, 1))
    pair_node = np.c_[np.arange(21, 42), np.arange(42, 63)]
    area = np.bincount(quad.ravel(), minlength=21) * 1e-4 / 4
    return xr.Dataset(
        {
            "coordinate": (("node", "axis"), coordinate),
            "connectivity": (("element", "corner"), np.concatenate([bar_a, bar_b])),
            "part": ("element", np.repeat([0, 1], 12)),
            "pair_node": (("pair", "side"), pair_node),
            "position": (("pair", "axis"), coordinate[21:42]),
            "area": ("pair", area),
        },
        coords={"axis": ["x", "y", "z"]},
    )


@pytest.fixture(scope="module")
def modes(assembly):
    x = assembly["coordinate"].sel(axis="x").to_numpy()
    shape = np.zeros((x.size, 3, 2))
    shape[:, 2] = np.c_[x**2, x**3 - 0.03 * x**2]
    return xr.Dataset(
        {
            "mode_shape": (("node", "axis", "mode"), shape),
            "natural_frequency": ("mode", [70.62, 360.59]),
        },
        coords={"axis": ["x", "y", "z"]},
    )


@pytest.fixture(scope="module")
def preload(assembly):
    load = np.clip(500 - 2e4 * assembly["position"].sel(axis="x"), 0, None)
    return xr.Dataset(
        {
            "normal_load": load.drop_vars("axis"),
            "gap": ("pair", np.where(load > 0, 0, 1e-6)),
            "position": assembly["position"],
        }
    )


@pytest.fixture(scope="module")
def bolted():
    """Two bars and two bolts, coarsely meshed."""
    return build_assembly(Assembly.model_validate(BOLTED))


@pytest.fixture(scope="module")
def regions():
    nodes = make_joint()
    return partition_regions(nodes, make_preload(nodes), 3)


@pytest.fixture(scope="module")
def variable(assembly):
    """A joint under variable normal load on all pairs of the small assembly, some of them open."""
    position = assembly["position"].to_numpy()
    joint = make_joint(len(position), law="variable")
    return replace(joint, position=position, element_position=position)


@pytest.fixture(scope="module")
def variable_response(variable):
    return solve_response(variable, FORCES, loss_factor=0.01)


@pytest.fixture(scope="module")
def reduced(regions):
    fitted, fit = fit_reduced_joint(regions, 2, starts=2)
    return joint_to_dataset(fitted).merge(fit)


@pytest.fixture(scope="module")
def reference():
    return solve_response(make_joint(), FORCES, loss_factor=0.01)


@pytest.fixture(scope="module")
def response(regions):
    return solve_response(regions, FORCES, loss_factor=0.01)


def shapes(axes):
    return [c for c in axes.collections if isinstance(c, PathCollection)]


def curves(axes):
    """What was drawn of each method and level, by name."""
    lines = (line for line in axes.get_lines() if not line.get_label().startswith("_"))
    return {line.get_label(): line.get_xydata() for line in lines}


def marks(axes, marker):
    return [line.get_xydata()[0] for line in axes.get_lines() if line.get_marker() == marker]


def legend_texts(axes):
    legends = [axes.get_legend(), *axes.figure.legends]
    return [text.get_text() for legend in legends for text in legend.get_texts()]


def test_a_mode_is_the_section_moved_by_its_shape(assembly, modes):
    figure = plot_modes(assembly, modes)
    assert [axes.get_title() for axes in figure.axes] == ["mode 1: 70.6 Hz", "mode 2: 360.6 Hz"]
    for axes, shape in zip(figure.axes, modes["mode_shape"].to_numpy()[:, 2].T, strict=True):
        (at_rest,) = axes.collections[0].get_paths()
        (moved,) = shapes(axes)[0].get_paths()
        x, rise = (moved.vertices[:-1] - at_rest.vertices[:-1]).T
        # bar A: a row of nodes at the bottom and one at the top, z does not change along y
        along = at_rest.vertices[:-1, 0] * 1e-3
        expected = np.interp(along, np.linspace(0, 0.06, 7), shape[:21:3])
        np.testing.assert_allclose(x, 0, atol=1e-12)
        largest = np.abs(shape).max()
        np.testing.assert_allclose(rise / np.abs(rise).max(), expected / largest, atol=1e-12)
    assert figure.get_supxlabel() == "x (mm)"
    assert figure.get_supylabel().startswith("z (mm)")


def test_many_modes_stand_in_two_columns(assembly, modes):
    six = xr.concat([modes] * 3, "mode", data_vars="minimal")
    panels = [axes for axes in plot_modes(assembly, six).axes if axes.get_title()]
    assert len(panels) == 6
    assert len({axes.get_subplotspec().colspan.start for axes in panels}) == 2


def test_what_is_drawn_of_the_mesh_is_what_is_not_hidden(bolted):
    axes = plot_mesh(bolted).axes[0]
    filled = [c for c in shapes(axes) if c.get_facecolor().size]
    grey = [np.ptp(c.get_facecolor()[0, :3]) < 1e-9 for c in filled]
    area = [polygon_area(c.get_paths()[0].to_polygons()) for c in filled]
    length, width, height = 60 + 62 + 50, 20, 16
    towards = np.array(_VIEW) / np.linalg.norm(_VIEW)
    top = length * width - 2 * np.pi * 6.5**2  # heads sit on the rest
    sides = width * height, length * height, top
    of_bars = sum(a for a, is_bolt in zip(area, grey, strict=True) if not is_bolt)
    assert of_bars == pytest.approx(sides @ np.abs(towards))
    # heads and nuts are painted after and before the bars
    assert grey[0] and grey[-1] and not all(grey)


def test_main_dimensions_are_written(bolted):
    view, plan, side = plot_mesh(bolted).axes
    written = [{text.get_text() for text in axes.texts} for axes in (view, plan, side)]
    assert written[0] == {"", "  clamped", " excitation along z", "   response along z"}
    assert written[1] == {"", "16", "30", "20", "holes ⌀ 9"}
    assert written[2] == {"", "60", "62", "50", "172", "16", "8"}
    counts = f"{bolted.sizes['element']} elements, {bolted.sizes['node']} nodes"
    assert view.get_title(loc="left") == counts


def test_every_edge_of_the_mesh_is_drawn_once(bolted):
    axes = plot_mesh(bolted).axes[0]
    lines = [c.get_paths()[0] for c in shapes(axes) if not c.get_facecolor().size]
    assert len(lines) == 5  # bar A: end, side and top; bar B: side and top
    for path in lines:
        drawn = path.to_polygons(closed_only=False)
        edges = [frozenset(map(tuple, edge)) for line in drawn for edge in pairwise(line)]
        assert len(edges) == len(set(edges)) > 20


def test_a_deformed_section_is_moved_by_its_displacement(bolted):
    x = bolted["coordinate"].sel(axis="x")
    moved = xr.zeros_like(bolted["coordinate"])
    moved.loc[{"axis": "z"}] = -4e-5 * (x / x.max()) ** 2
    figure = plot_deformation(bolted, xr.Dataset({"displacement": moved}))
    whole, lap = figure.axes
    # 0.4 of 27 mm over 40 um is 270
    assert whole.get_title(loc="left") == "whole assembly, displacements × 200"
    for axes in (whole, lap):
        for at_rest, drawn in zip(
            (c for c in axes.collections if isinstance(c, LineCollection)),
            shapes(axes),
            strict=True,
        ):
            rest = np.concatenate([path.vertices for path in at_rest.get_paths()])
            there = drawn.get_paths()[0].vertices
            expected = -4e-2 * 200 * (there[:, 0] / 172) ** 2
            np.testing.assert_allclose(there - rest, np.c_[0 * expected, expected])
    assert lap.get_xlim() == pytest.approx((60 - 9.3, 122 + 9.3))
    assert lap.get_ylabel() == "z (mm)"


def test_assembly_and_displacement_must_belong_together(bolted, assembly):
    other = xr.Dataset({"displacement": 0 * assembly["coordinate"]})
    with pytest.raises(ValueError, match="different nodes"):
        plot_deformation(bolted, other)


def test_a_section_needs_faces_on_the_plane(assembly, modes):
    beside = assembly.assign(coordinate=assembly["coordinate"] + 1e-3)
    with pytest.raises(ValueError, match="no faces in the plane y = 0"):
        plot_modes(beside, modes)


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


def test_loads_along_the_middle_are_those_of_the_pairs(assembly, preload):
    axes = plot_contact(assembly, preload).axes[3]
    drawn = np.concatenate([line.get_xydata() for line in axes.get_lines()])
    middle = np.arange(1, 21, 3)
    x = assembly["position"].sel(axis="x").to_numpy() * 1e3
    expected = np.c_[x, preload["normal_load"].to_numpy()][middle]
    np.testing.assert_allclose(drawn[np.argsort(drawn[:, 0])], expected)
    (line,) = [c for c in axes.collections if isinstance(c, LineCollection)]
    assert len(line.get_segments()) == 6


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


def on_pairs(assembly, loaded):
    """A joint of two regions on some pairs of the small assembly."""
    nodes = make_joint(len(loaded))
    part = joint_to_dataset(partition_regions(nodes, make_preload(nodes), 2))
    position = assembly["position"].isel(pair=loaded).rename(pair="element")
    load = np.arange(1.0, len(loaded) + 1)
    region = (np.arange(len(loaded)) >= 9).astype(int)
    return part.assign(
        element_position=position,
        slip_force=("element", load),
        point_of_element=("element", region),
    )


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


def test_loops_are_whole_and_end_on_the_loading_curve(reduced, regions):
    (axes,) = plot_loops(reduced, joint_to_dataset(regions), region=2).axes
    drawn = curves(axes)
    assert len(drawn) == 3 * 2
    of = regions.law.point_of_element == 1
    law = regions.law.tangential_stiffness[of], regions.law.slip_force[of]
    for loop in range(3):
        amplitude = reduced["loop_amplitude"].to_numpy()[1, loop]
        many = drawn[f"region 2, all its {of.sum()} elements, {amplitude * 1e6:.3g} μm"]
        half = len(many) // 2
        np.testing.assert_allclose(many[:half], -many[half:])
        tip = [amplitude * 1e6, loading_curve(np.array(amplitude), *law)]
        np.testing.assert_allclose(many[0], tip)
        # from tip to tip and back
        np.testing.assert_allclose(many[half - 1], many[half], rtol=1e-9)
        few = drawn[f"the 2 fitted to them, {amplitude * 1e6:.3g} μm"]
        np.testing.assert_allclose(
            few[:half, 1], reduced["loop_force_of_fit"].to_numpy()[1, loop], rtol=1e-12
        )
    assert axes.get_xlabel() == "relative displacement (μm)"
    assert axes.get_ylabel() == "friction force (N)"
    texts = legend_texts(axes)
    assert f"region 2, all its {of.sum()} elements" in texts
    assert "the 2 fitted to them" in texts


def test_open_elements_have_no_part_in_loops():
    nodes = make_joint(law="variable")
    regions = partition_regions(nodes, make_preload(nodes), 3)
    fitted, fit = fit_reduced_joint(regions, 2, starts=2)
    reduced = joint_to_dataset(fitted).merge(fit)
    (axes,) = plot_loops(reduced, joint_to_dataset(regions)).axes
    first = regions.law.point_of_element == 0
    loaded = np.sum(regions.law.normal_load[first] > 0)
    assert loaded < first.sum()
    expected = f"region 1, its {loaded} elements under load, of {first.sum()}"
    assert expected in legend_texts(axes)


def state_areas(axes):
    """Area [mm2] drawn for each colour."""
    return {
        tuple(c.get_facecolor()[0]): polygon_area(c.get_paths()[0].to_polygons())
        for c in shapes(axes)
    }


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
    solved = solve_response(nodes, [0.01, 5.0], loss_factor=0.01)
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


@pytest.mark.parametrize("region", [0, 4])
def test_loops_need_a_region(reduced, regions, region):
    with pytest.raises(ValueError, match=f"region {region} of 3"):
        plot_loops(reduced, joint_to_dataset(regions), region)


def test_a_response_is_drawn_over_its_reference(response, reference):
    (axes,) = plot_response(response, "regions=3", "linear", reference).axes
    drawn = curves(axes)
    assert len(drawn) == 2 * len(FORCES)
    for name, solved in (("3 regions", response), ("node-to-node", reference)):
        for force in FORCES:
            mine = solved["excitation_force"].to_numpy() == force
            expected = [solved["frequency"], solved["response_amplitude"] * 1e3 / force]
            found = drawn[f"{name}, linear modes, {force:g} N"]
            np.testing.assert_allclose(found, np.stack(expected, axis=-1)[mine])
    assert axes.get_xlabel() == "frequency (Hz)"
    assert axes.get_ylabel() == "response / force (mm/N)"
    assert axes.get_yscale() == "log"
    texts = legend_texts(axes)
    assert texts[:2] == ["node-to-node, linear modes", "3 regions, linear modes"]
    assert texts[-3:] == ["0.01 N", "5 N", "20 N"]
    assert "branch breaks off" not in texts
    assert not marks(axes, "X")


def test_peaks_are_marked_and_in_view(response, reference):
    (axes,) = plot_response(response, "regions=3", "linear", reference).axes
    expected = [
        (frequency, 1e3 * amplitude / force)
        for solved in (reference, response)
        for frequency, amplitude, force in zip(
            *(solved[name].to_numpy() for name in ("peak_frequency", "peak_amplitude")),
            FORCES,
            strict=True,
        )
    ]
    np.testing.assert_allclose(marks(axes, "o"), expected)
    low, high = axes.get_xlim()
    assert all(low < frequency < high for frequency, _ in expected)


def test_only_what_is_near_a_peak_is_in_view():
    stuck = solve_response(make_joint(), [1e-4], loss_factor=0.01)
    (axes,) = plot_response(stuck, "node-to-node", "linear").axes
    peak = stuck["peak_frequency"].item()
    low, high = axes.get_xlim()
    assert stuck["frequency"].min() < 0.9 * peak < low < peak < high
    # a sharp peak still has something on both sides
    assert low < 0.985 * peak


def test_a_level_has_one_colour_in_both_methods(response, reference):
    (axes,) = plot_response(response, "regions=3", "linear", reference).axes
    colours = {}
    for line in axes.get_lines():
        if not line.get_label().startswith("_"):
            level = line.get_label().rpartition(", ")[2]
            colours.setdefault(level, set()).add(tuple(line.get_color()))
    assert [len(found) for found in colours.values()] == [1, 1, 1]
    assert len(set.union(*colours.values())) == 3


def test_a_broken_path_ends_in_a_cross_and_is_named(regions, reference):
    short = StepControl(maximum_solutions=12)
    broken = solve_response(regions, FORCES, loss_factor=0.01, control=short)
    (axes,) = plot_response(broken, "regions=3", "linear", reference).axes
    crosses = marks(axes, "X")
    assert len(crosses) == len(FORCES)
    for force, cross in zip(FORCES, crosses, strict=True):
        np.testing.assert_allclose(cross, curves(axes)[f"3 regions, linear modes, {force:g} N"][-1])
        assert axes.get_xlim()[0] <= cross[0] <= axes.get_xlim()[1]
    texts = legend_texts(axes)
    assert "branch breaks off" in texts
    assert f"5 N\nbreaks off at {crosses[1][0]:.1f} Hz" in texts


def test_what_did_not_converge_is_not_drawn_as_a_solution(reference):
    failed = reference.assign(
        converged=reference["converged"] * (reference["excitation_force"] != 5.0),
        complete=reference["complete"] * (reference["force_level"] != 5.0),
    )
    (axes,) = plot_response(failed, "node-to-node", "linear").axes
    assert len(curves(axes)["node-to-node, linear modes, 5 N"]) == 0
    assert "5 N\nno solution found" in legend_texts(axes)


@pytest.mark.parametrize(
    ("joint", "coordinates", "words"),
    [
        ("node-to-node", "linear", "node-to-node, linear modes"),
        ("regions=6", "rdnm-1", "6 regions, 1 RDNM"),
        ("clusters=auto", "complex-rdnm-2", "clusters to tolerance, 2 complex RDNM"),
        ("regions=6/table", "backbone", "6 regions, tabulated, backbone"),
        (
            "clusters=2/harmonic=3",
            "linear",
            "2 clusters of 3 elements, harmonic fit, linear modes",
        ),
    ],
)
def test_methods_are_named_in_words(reference, joint, coordinates, words):
    (axes,) = plot_response(reference, joint, coordinates).axes
    assert legend_texts(axes)[0] == words
    assert len(curves(axes)) == len(FORCES)


def test_response_and_reference_need_the_same_forces(response, reference):
    other = reference.assign(force_level=reference["force_level"] * 2)
    with pytest.raises(ValueError, match="different forces"):
        plot_response(response, "regions=3", "linear", other)


@pytest.fixture(scope="module")
def times():
    """Times of two joints, of which the second breaks off at the highest force."""
    row = {"coordinates": "linear", "resonance": 1, "complete": True}
    nodes = {**row, "joint": "node-to-node", "published_reduction_percent": 0.0}
    few = {**row, "joint": "regions=2/elements=3", "published_reduction_percent": 97.5}
    rows = [
        {**nodes, "force_N": 0.001, "cpu_s": 4.0, "reduction_percent": 0.0},
        {**nodes, "force_N": 10.0, "cpu_s": 5.0, "reduction_percent": 0.0},
        {**few, "force_N": 0.001, "cpu_s": 1.0, "reduction_percent": 75.0},
        {**few, "force_N": 10.0, "cpu_s": 0.5, "reduction_percent": np.nan, "complete": False},
    ]
    table = pd.DataFrame(rows)
    table["cpu_forward_difference_s"] = 3 * table["cpu_s"]
    return table.assign(reduction_forward_difference_percent=table["reduction_percent"])


def test_times_stand_over_their_ratios_to_the_reference(times):
    figure = plot_times(times)
    analytic, differences, ratios, beside_published = figure.axes
    few = "2 regions of 3 elements, linear modes"
    np.testing.assert_array_equal(curves(analytic)[few], [[0, 1], [1, np.nan]])
    np.testing.assert_array_equal(curves(differences)[few], [[0, 3], [1, np.nan]])
    np.testing.assert_array_equal(curves(ratios)[few], [[0, 0.25], [1, np.nan]])
    np.testing.assert_allclose(marks(analytic, "X"), [[1, 0.5]])
    published = curves(beside_published)[f"{few}, published"]
    np.testing.assert_allclose(published, [[0, 0.025], [1, 0.025]])
    assert f"{few}, published" not in curves(ratios)
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == [
        "node-to-node",
        "2 regions of 3 elements",
        "linear modes",
        "published",
        "branch breaks off",
    ]


def test_times_of_an_unpublished_case_mention_none(times):
    figure = plot_times(times.assign(published_reduction_percent=np.nan, complete=True))
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["node-to-node", "2 regions of 3 elements", "linear modes"]


def test_times_without_forward_differences_are_drawn_by_the_analytic_jacobian(times):
    without = times.assign(
        cpu_forward_difference_s=np.nan,
        reduction_forward_difference_percent=np.nan,
        published_reduction_percent=np.nan,
    )
    analytic, ratios = plot_times(without).axes
    np.testing.assert_array_equal(curves(analytic)["node-to-node, linear modes"], [[0, 4], [1, 5]])
    assert ratios.get_ylabel().startswith("over that of the node-to-node")


def test_all_coordinates_have_lines_of_their_own(times):
    row = times.iloc[[0]]
    names = ("linear", "rdnm-1", "complex-rdnm-1", "backbone")
    solved = pd.concat([row.assign(coordinates=name) for name in names])
    lines = plot_times(solved).axes[0].get_lines()
    assert len({(line.get_linestyle(), line.get_marker()) for line in lines}) == len(names)


def test_times_need_a_resonance_that_was_solved(times):
    with pytest.raises(ValueError, match="around resonance 2"):
        plot_times(times, resonance=2)


def test_errors_of_sampling_fall_beside_a_line_of_second_order():
    samples = np.array([64, 128, 256])
    rows = [
        {"case": "one", "law": law, "samples": n, "force_N": force, "error_relative": force / n**2}
        for law in ("constant", "variable")
        for force in (1.0, 5.0)
        for n in samples
    ]
    figure = plot_sampling(pd.DataFrame(rows))
    titles = [axes.get_title() for axes in figure.axes]
    assert titles == ["one, constant normal load", "one, variable normal load"]
    for axes in figure.axes:
        drawn = curves(axes)
        np.testing.assert_allclose(drawn["1 N"], np.c_[samples, 1 / samples**2.0])
        np.testing.assert_allclose(drawn["5 N"], drawn["second order"])
        assert axes.get_xscale() == axes.get_yscale() == "log"


@pytest.fixture
def by_basis():
    """Errors of two free and two enriched bases at two levels; the last is without error."""
    bases = {"free-4": 4, "free-8": 8, "enriched-8": 8, "enriched-16": 16}
    rows = [
        {"basis": basis, "vectors": vectors, "level": level, "error": level * (16 - vectors)}
        for basis, vectors in bases.items()
        for level in (1.0, 5.0)
    ]
    return pd.DataFrame(rows)


def lines_of_bases(axes, label):
    """What is drawn of enriched bases under a label, and of free ones in the same colour."""
    (enriched,) = (line for line in axes.get_lines() if line.get_label() == label)
    (free,) = (
        line
        for line in axes.get_lines()
        if line is not enriched and np.array_equal(line.get_color(), enriched.get_color())
    )
    assert enriched.get_linestyle() != free.get_linestyle()
    return enriched.get_xydata(), free.get_xydata()


def test_peaks_of_bases_are_drawn_over_their_size(by_basis):
    names = {"level": "force_N", "error": "peak_frequency_error_percent"}
    table = by_basis.rename(columns=names)
    # signs are left out, as a logarithm has none
    table["peak_amplitude_error_percent"] = -10 * table["peak_frequency_error_percent"]
    for axes, scale in zip(plot_bases(table).axes, (1, 10), strict=True):
        for label, force in (("1 N", 1), ("5 N", 5)):
            enriched, free = lines_of_bases(axes, label)
            np.testing.assert_allclose(enriched, [[8, scale * force * 8]])
            np.testing.assert_allclose(free, [[4, scale * force * 12], [8, scale * force * 8]])


def test_patterns_are_drawn_by_the_worst_of_them(by_basis):
    table = by_basis.rename(columns={"level": "resonance", "error": "error_percent"})
    table["resonance"] = table["resonance"].astype(int)
    less = table.assign(error_percent=table["error_percent"] / 3)
    parts = [
        some.assign(springs=springs, pattern=pattern)
        for springs in ("x", "xz")
        for pattern, some in (("all", less), ("left", table))
    ]
    for axes in plot_patterns(pd.concat(parts)).axes:
        enriched, free = lines_of_bases(axes, "resonance 5")
        np.testing.assert_allclose(enriched, [[8, 40]])
        np.testing.assert_allclose(free, [[4, 60], [8, 40]])


def test_models_are_drawn_by_their_largest_errors_beside_their_cost():
    rows = [
        {
            "modes": basis,
            "joint": "node-to-node",
            "coordinates": coordinates,
            "force_N": force,
            "complete": coordinates == "linear" or force < 5,
            "peak_frequency_error_percent": -size * force,
            "peak_amplitude_error_percent": 10 * size * force,
            "cpu_s": 0.5 * force,
        }
        for basis, coordinates, size in (
            ("free-4", "linear", 2.0),
            ("free-4", "rdnm-1", 3.0),
            ("enriched-8", "linear", 0.0),
        )
        for force in (1.0, 5.0)
    ]
    errors, costs = plot_models(pd.DataFrame(rows)).axes
    # enriched bases come first; the one that is compared with has no error
    words = [label.get_text() for label in errors.get_yticklabels()]
    assert words == [
        "enriched-8, node-to-node, linear modes",
        "free-4, node-to-node, linear modes",
        "free-4, node-to-node, 1 RDNM",
    ]
    whole, broken = (
        [line.get_xydata()[0] for line in errors.get_lines() if line.get_marker() == marker]
        for marker in ("o", "X")
    )
    np.testing.assert_allclose(whole, [[10, 1], [100, 1]])
    np.testing.assert_allclose(broken, [[15, 2], [150, 2]])
    np.testing.assert_allclose([line.get_xydata()[0] for line in costs.get_lines()][2], [3, 2])


def test_divisions_are_drawn_by_their_largest_error():
    rows = [
        {
            "division": division,
            "motion": "mean",
            "regions": count,
            "region_error_percent": 2.0 / count,
            "force_N": force,
            "peak_frequency_error_percent": -force / count,
            "peak_amplitude_error_percent": 3 * force / count,
        }
        for division in ("equal-load", "clusters")
        for count in (2, 4)
        for force in (1.0, 5.0)
    ]
    figure = plot_divisions(pd.DataFrame(rows))
    for axes, scale in zip(figure.axes, (1, 3), strict=True):
        drawn = curves(axes)
        for label in ("equal load, mean", "clusters, mean"):
            np.testing.assert_allclose(drawn[label], [[2, scale * 2.5], [4, scale * 1.25]])
    dotted = [line for line in figure.axes[0].get_lines() if line.get_linestyle() == ":"]
    for line in dotted:
        np.testing.assert_allclose(line.get_xydata(), [[2, 1], [4, 0.5]])
    assert len(dotted) == 2


def test_the_same_figure_has_the_same_bytes(assembly, modes, preload, bolted, tmp_path):
    for name in ("first", "second"):
        save_figure(plot_modes(assembly, modes), tmp_path / name / "modes.svg")
        save_figure(plot_contact(assembly, preload), tmp_path / name / "contact.svg")
        save_figure(plot_mesh(bolted), tmp_path / name / "mesh.svg")
    for name in ("modes.svg", "contact.svg", "mesh.svg"):
        written = (tmp_path / "first" / name).read_bytes()
        assert written == (tmp_path / "second" / name).read_bytes()
        assert not re.search(rb"<dc:date>", written)


def test_another_process_writes_the_same_bytes(response, reference, tmp_path):
    figure = plot_response(response, "regions=3", "linear", reference)
    save_figure(figure, tmp_path / "here.svg")
    dataset.save(response, tmp_path / "response.nc")
    dataset.save(reference, tmp_path / "reference.nc")
    program = (
        "from boltjoint import dataset\n"
        "from boltjoint.report.figures.responses import plot_response\n"
        "from boltjoint.report.figures.style import save_figure\n"
        "response, reference = (dataset.load(f'{n}.nc') for n in ('response', 'reference'))\n"
        "figure = plot_response(response, 'regions=3', 'linear', reference)\n"
        "save_figure(figure, 'there.svg')\n"
    )
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=True)
    assert Path(tmp_path, "here.svg").read_bytes() == Path(tmp_path, "there.svg").read_bytes()


def polygon_area(polygons):
    """Area [of the square unit] of closed loops, those around holes running the other way."""
    return sum(
        np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) / 2 for x, y in (loop.T for loop in polygons)
    )


def without_solutions(response):
    """The same response, of which nothing was found."""
    lost = response.copy(deep=True)
    lost["complete"][:], lost["converged"][:] = 0, 0
    lost["peak_frequency"][:], lost["peak_amplitude"][:] = np.nan, np.nan
    return lost.isel(solution=slice(0))


def texts_in(figure):
    return [text.get_text() for axes in figure.axes for text in axes.texts]


@pytest.mark.parametrize("lost", ["nothing found", "one solution", "nothing converged"])
def test_a_response_that_failed_has_a_figure_that_says_so(regions, response, lost, tmp_path):
    if lost == "one solution":
        alone = StepControl(maximum_solutions=1)
        solved = solve_response(regions, FORCES, loss_factor=0.01, control=alone)
        assert solved.sizes["solution"] == len(FORCES)
    elif lost == "nothing converged":
        solved = response.assign(converged=0 * response["converged"])
        solved = solved.assign(complete=0 * response["complete"])
    else:
        solved = without_solutions(response)
    figure = plot_response(solved, "regions=3", "linear")
    save_figure(figure, tmp_path / "response.svg")
    texts = legend_texts(figure.axes[0])
    if lost == "one solution":
        assert f"5 N\nbreaks off at {float(solved['frequency'][1]):.1f} Hz" in texts
        low, high = figure.axes[0].get_xlim()
        assert low < float(solved["frequency"][1]) < high
    else:
        assert "5 N\nno solution found" in texts
        assert texts_in(figure) == ["no results"]


def test_solutions_that_no_sweep_shows_are_dashed(response):
    folded = response.copy(deep=True)
    mine = np.flatnonzero(folded["excitation_force"] == 5.0)
    hidden = mine[20:25]
    for name in ("on_sweep_up", "on_sweep_down"):
        folded[name][hidden] = 0
    (axes,) = plot_response(folded, "regions=3", "linear").axes
    solid = curves(axes)["3 regions, linear modes, 5 N"]
    assert np.isnan(solid[20:25, 1]).all()
    assert np.isfinite(np.delete(solid, slice(20, 25), axis=0)).all()
    (dashed,) = (line for line in axes.get_lines() if line.get_linestyle() == "--")
    shown = np.flatnonzero(np.isfinite(dashed.get_ydata()))
    # joined to what a sweep shows
    np.testing.assert_array_equal(shown, np.arange(19, 26))
    assert "not shown by slow sweeps" in legend_texts(axes)


def test_a_response_that_linear_modes_stand_for_is_named(response):
    replaced = response.copy(deep=True)
    replaced["fell_back"][1] = 1
    (axes,) = plot_response(replaced, "node-to-node", "rdnm-1").axes
    assert "5 N\nlinear modes instead" in legend_texts(axes)


def test_times_of_a_case_all_of_whose_branches_broke_off_have_a_figure(times, tmp_path):
    reductions = [name for name in times if "reduction" in name]
    failed = times.assign(complete=False, **dict.fromkeys(reductions, np.nan))
    figure = plot_times(failed)
    save_figure(figure, tmp_path / "times.svg")
    # times are marked as those of branches that broke off, ratios have nothing to stand on
    crosses = [line for line in figure.axes[0].get_lines() if line.get_marker() == "X"]
    assert sum(line.get_xdata().size for line in crosses) == len(failed)
    assert texts_in(figure) == ["no results"] * 2

    # where only one of them has none, the other keeps the axis that both share
    failed = times.assign(reduction_percent=np.nan)
    figure = plot_times(failed)
    save_figure(figure, tmp_path / "times.svg")
    assert texts_in(figure) == ["no results"]
    assert figure.axes[3].get_yscale() == "log"


def test_a_table_without_rows_has_a_figure(tmp_path):
    empty = pd.DataFrame(columns=["case", "law", "samples", "force_N", "error_relative"])
    figure = plot_sampling(empty)
    save_figure(figure, tmp_path / "sampling.svg")
    assert texts_in(figure) == ["no results"]


def test_a_backbone_without_states_has_a_figure(tmp_path):
    joint = make_joint()
    found = find_backbone(joint, [5.0], loss_factor=0.01, window=frequency_window(joint))
    for count in (0, 1):
        some = found.isel(state=slice(count))
        figure = plot_backbones({"node-to-node": some}, [5.0])
        save_figure(figure, tmp_path / "backbone.svg")
        assert texts_in(figure) == ["no results"] * (2 if count == 0 else 0)
