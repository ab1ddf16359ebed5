import numpy as np
import pandas as pd
import pytest
from figure_parts import curves, marks, texts_in

from boltjoint.report.figures.responses import plot_times
from boltjoint.report.figures.style import save_figure

PUBLISHED = ("published", "published_reduction_percent")


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
    table["complete_forward_difference"] = table["complete"]
    return table.assign(reduction_forward_difference_percent=table["reduction_percent"])


def test_times_stand_over_their_ratios_to_the_reference(times):
    figure = plot_times(times, source=PUBLISHED)
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


def test_a_path_that_broke_off_with_one_jacobian_is_no_broken_one_with_the_other(times):
    analytic, differences, *_ = plot_times(times.assign(complete=True)).axes
    few = "2 regions of 3 elements, linear modes"
    np.testing.assert_array_equal(curves(analytic)[few], [[0, 1], [1, 0.5]])
    np.testing.assert_array_equal(curves(differences)[few], [[0, 3], [1, np.nan]])
    assert not any(line.get_marker() == "X" for line in analytic.get_lines())
    np.testing.assert_allclose(marks(differences, "X"), [[1, 1.5]])


def test_times_of_an_unpublished_case_mention_none(times):
    whole = {"complete": True, "complete_forward_difference": True}
    figure = plot_times(times.assign(published_reduction_percent=np.nan, **whole), source=PUBLISHED)
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
    assert ratios.get_ylabel().startswith("time over that of")


def test_all_coordinates_have_lines_of_their_own(times):
    row = times.iloc[[0]]
    names = ("linear", "rdnm-1", "complex-rdnm-1", "backbone")
    solved = pd.concat([row.assign(coordinates=name) for name in names])
    lines = plot_times(solved).axes[0].get_lines()
    assert len({(line.get_linestyle(), line.get_marker()) for line in lines}) == len(names)


def test_times_need_a_resonance_that_was_solved(times):
    with pytest.raises(ValueError, match="around resonance 2"):
        plot_times(times, resonance=2)


def test_times_of_a_case_all_of_whose_branches_broke_off_have_a_figure(times, tmp_path):
    reductions = [name for name in times if "reduction" in name]
    paths = dict.fromkeys(("complete", "complete_forward_difference"), False)
    failed = times.assign(**paths, **dict.fromkeys(reductions, np.nan))
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
