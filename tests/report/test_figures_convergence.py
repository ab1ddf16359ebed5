import numpy as np
import pandas as pd
import pytest
from figure_parts import curves, texts_in
from matplotlib import rc_context
from matplotlib.text import Text
from text_boxes import faults

from boltjoint.report.figures.convergence import (
    plot_bases,
    plot_divisions,
    plot_models,
    plot_patterns,
    plot_reductions,
    plot_sampling,
)
from boltjoint.report.figures.style import STYLE, save_figure


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


def test_reductions_are_drawn_by_their_largest_error_and_mean_time():
    def table(factor):
        rows = [
            {
                "joint": joint,
                "cpu_s": factor * cpu * force,
                "complete": joint != "regions=4" or factor == 1,
                "force_N": force,
                "peak_frequency_error_percent": -factor * error * force,
                "peak_amplitude_error_percent": 3 * factor * error * force,
            }
            for joint, cpu, error in (
                ("node-to-node", 8.0, 0.0),
                ("regions=4", 1.0, 10.0),
                ("hyper=20", 0.25, 1.0),
                ("hyper=40", 0.5, 0.125),
                ("hyper=auto", 0.75, 0.25),
            )
            for force in (1.0, 3.0)
        ]
        return pd.DataFrame(rows)

    tables = {
        ("constant", "one"): table(1.0),
        ("constant", "other"): table(2.0),
        ("variable", "third"): table(1.0),
    }
    figure = plot_reductions(tables, {"frequency_tolerance": 1e-3, "amplitude_tolerance": 0.01})
    assert [axes.get_title() for axes in figure.axes[:2]] == [
        "constant normal load",
        "variable normal load",
    ]
    # of two cases under constant load the other has twice the errors and times
    for axes, factor in zip(figure.axes, (2, 1, 6, 3), strict=True):
        points = [line.get_xydata() for line in axes.get_lines()]
        time = 1.5 if axes in figure.axes[::2] else 1
        expected = [[0.5 * time, 3.0 * factor], [1.0 * time, 0.375 * factor]]
        assert any(np.allclose(each, expected) for each in points if len(each) == 2)
        crosses = [line for line in axes.get_lines() if line.get_marker() == "X"]
        assert len(crosses) == (axes in figure.axes[::2])
        # what there is one number of has it in the legend
        assert {text.get_text() for text in axes.texts} == {"20", "40", "auto"}
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert legend == ["4 bands", "weighted pairs"]


def test_a_table_without_rows_has_a_figure(tmp_path):
    empty = pd.DataFrame(columns=["case", "law", "samples", "force_N", "error_relative"])
    figure = plot_sampling(empty)
    save_figure(figure, tmp_path / "sampling.svg")
    assert texts_in(figure) == ["no results"]


def test_labels_of_points_cover_neither_each_other_nor_marks():
    # points closer together than their labels are wide, on curves that cross each other
    joints = [("node-to-node", 10.0, 0.0)]
    for kind, factor in (("regions", 1.0), ("clusters", 1.03), ("hyper", 1.06)):
        joints += [
            (f"{kind}={count}", factor * (1 + 0.02 * place), 1.2 * factor**place)
            for place, count in enumerate((4, 12, 24, 48))
        ]
    rows = [
        {
            "joint": joint,
            "cpu_s": cpu,
            "complete": True,
            "peak_frequency_error_percent": error,
            "peak_amplitude_error_percent": error,
        }
        for joint, cpu, error in joints
    ]
    tolerances = {"frequency_tolerance": 1e-3, "amplitude_tolerance": 0.01}
    figure = plot_reductions({("constant", "one"): pd.DataFrame(rows)}, tolerances)
    assert not faults(figure)
    with rc_context(STYLE):
        figure.draw_without_rendering()
    for axes in figure.axes:
        boxes = [Text.get_window_extent(text) for text in axes.texts]
        assert len(boxes) == 12
        for line in axes.get_lines():
            if line.get_marker() == "o":
                points = axes.transData.transform(line.get_xydata())
                assert not any(box.contains(*point) for box in boxes for point in points)
        for text, box in zip(axes.texts, boxes, strict=True):
            middle = (box.p0 + box.p1) / 2
            away = np.abs(middle - axes.transData.transform(text.xy)).max()
            assert away < 40 * figure.dpi / 72
