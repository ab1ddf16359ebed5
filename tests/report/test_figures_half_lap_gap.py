import numpy as np
import pytest
from figure_parts import curves, legend_texts, polygon_area, shapes
from matplotlib.collections import LineCollection

from boltjoint.structure.makers.half_lap.figures import plot_initial_gap


@pytest.fixture
def hollow(assembly):
    x = assembly["position"].sel(axis="x").to_numpy()
    return assembly.assign(initial_gap=("pair", 5e-6 * (1 - (x / 0.03 - 1) ** 2)))


def test_every_pair_is_drawn_with_its_gap(hollow):
    plan, profile, bar = plot_initial_gap(hollow).axes
    (cells,) = shapes(plan)
    drawn = [polygon_area(path.to_polygons()) for path in cells.get_paths()]
    # mm2 from m2
    np.testing.assert_allclose(drawn, hollow["area"].to_numpy() * 1e6)
    colours, gap = cells.get_facecolor(), hollow["initial_gap"].to_numpy()
    assert len(np.unique(colours, axis=0)) == len(np.unique(gap.round(12)))
    assert (profile.get_xlabel(), bar.get_ylabel()) == ("x (mm)", "initial gap (μm)")


def test_the_gap_is_drawn_along_the_middle_and_an_edge(hollow):
    profile = plot_initial_gap(hollow).axes[1]
    x = np.linspace(0, 60, 7)
    expected = np.c_[x, 5 * (1 - (x / 30 - 1) ** 2)]
    np.testing.assert_allclose(curves(profile)["edge of the width"], expected, atol=1e-12)
    (middle,) = [each for each in profile.collections if isinstance(each, LineCollection)]
    ends = np.unique(np.concatenate(middle.get_segments()).round(9), axis=0)
    np.testing.assert_allclose(ends, expected, atol=1e-8)
    assert legend_texts(profile) == ["middle of the width", "edge of the width"]


def test_flat_surfaces_have_no_such_figure(assembly):
    with pytest.raises(ValueError, match="assembly has no initial gap: its surfaces are flat"):
        plot_initial_gap(assembly)
