from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from figure_parts import polygon_area, shapes
from fresh_imports import modules_loaded_by
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from small_study import ASSEMBLY

from boltjoint.config.lap_joint import LapJoint
from boltjoint.report.figures.style import save_figure
from boltjoint.structure.makers.half_lap.figures import (
    _VIEW,
    PART_COLOURS,
    plot_deformation,
    plot_mesh,
    plot_modes,
)
from boltjoint.structure.makers.half_lap.mesh import build_assembly


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


def test_washers_are_drawn_between_bars_and_heads():
    washer = {"thickness_mm": 1.6, "diameter_mm": 16}
    content = ASSEMBLY | {"bolts": ASSEMBLY["bolts"] | {"washer": washer}}
    figure = plot_mesh(build_assembly(LapJoint.model_validate(content)))
    assert [text.get_text() for text in figure.legends[0].texts] == [*PART_COLOURS]
    hue = {
        name: np.divide(to_rgb(colour), max(to_rgb(colour))).round(6)
        for name, colour in PART_COLOURS.items()
    }
    view, _, side = figure.axes
    kinds, area = [], {}
    for shape in shapes(view):
        if shape.get_facecolor().size:
            colour = shape.get_facecolor()[0, :3]
            (kind,) = (k for k, h in hue.items() if np.allclose(colour / colour.max(), h))
            kinds.append(kind)
            covered = polygon_area(shape.get_paths()[0].to_polygons())
            area[kind, kinds.count("bar A") > 0] = area.get((kind, kinds.count("bar A") > 0), 0)
            area[kind, kinds.count("bar A") > 0] += covered
    order = list(dict.fromkeys(kinds))
    assert order[:3] == ["bolts", "washers", "bar A"]
    assert list(dict.fromkeys(reversed(kinds)))[:3] == ["bolts", "washers", "bar B"]
    # of the upper washers the rim and the outside are seen, of the lower ones the outside
    towards = np.array(_VIEW) / np.linalg.norm(_VIEW)
    rim = 2 * np.pi / 4 * (16**2 - 13**2) * towards[2]
    assert area["washers", True] - area["washers", False] == pytest.approx(rim)
    # cut along the middle, each washer is two rectangles
    drawn = [s for s in shapes(side) if np.allclose(s.get_facecolor()[0, :3], to_rgb("#9c8f80"))]
    cut = sum(abs(polygon_area(s.get_paths()[0].to_polygons())) for s in drawn)
    assert cut == pytest.approx(2 * 2 * 1.6 * (16 - 9), rel=0.03)


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


def test_figures_import_no_compiler():
    loaded = modules_loaded_by("from boltjoint.structure.makers.half_lap import figures")
    assert not {"numba", "scipy"} & loaded


def test_the_same_figure_has_the_same_bytes(assembly, modes, bolted, tmp_path):
    for name in ("first", "second"):
        save_figure(plot_modes(assembly, modes), tmp_path / name / "modes.svg")
        save_figure(plot_mesh(bolted), tmp_path / name / "mesh.svg")
    for name in ("modes.svg", "mesh.svg"):
        written = (tmp_path / "first" / name).read_bytes()
        assert written == (tmp_path / "second" / name).read_bytes()
        assert b"<dc:date>" not in written
