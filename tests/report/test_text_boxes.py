from pathlib import Path

import numpy as np
import pytest
from figure_parts import on_pairs
from matplotlib.figure import Figure
from text_boxes import faults, readable_figures

from boltjoint.config.study import load_study
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.figures.regions import plot_regions
from boltjoint.reproduction.comparison import ThesisComparison
from boltjoint.study.artefact_list import Contents
from boltjoint.study.stage_inputs import Results


@pytest.fixture
def readable():
    """Figures of this file are made to fail, or checked by their test."""


def test_texts_that_overlap_are_found():
    axes = Figure().subplots()
    axes.text(0.5, 0.5, "peak")
    axes.text(0.7, 0.5, "apart")
    assert not faults(axes.figure)
    axes.text(0.51, 0.5, "upon")
    axes.text(0.51, 0.5, "unseen", visible=False)
    assert faults(axes.figure) == ["'peak' overlaps 'upon'"]


def test_labels_of_ticks_that_overlap_are_found():
    axes = Figure(figsize=(3, 2)).subplots()
    axes.set_xticks([0.0, 0.3, 1.0], ["tangential stiffness", "preload", "friction coefficient"])
    assert "'tangential stiffness' overlaps 'preload'" in faults(axes.figure)
    axes.tick_params(axis="x", rotation=90)
    assert not faults(axes.figure)
    # ticks beyond the limits are not drawn
    axes.set_xticks([0.0, 5.0, 5.001], ["0", "five", "more"])
    axes.set_xlim(0, 1)
    assert not faults(axes.figure)


def test_turned_texts_have_turned_boxes():
    axes = Figure().subplots()
    turned = {"rotation": 45, "ha": "center", "va": "center"}
    for x in (0.3, 0.36):
        axes.text(x, 0.5, "an oblique text", **turned)
    assert not faults(axes.figure)
    axes.text(0.31, 0.5, "a further text", **turned)
    assert faults(axes.figure) == ["'an oblique text' overlaps 'a further text'"]


def test_texts_that_are_cut_off_are_found():
    axes = Figure().subplots()
    text = axes.text(1.5, 0.5, "far outside")
    # the picture grows with it
    assert not faults(axes.figure)
    text.set_in_layout(False)
    assert faults(axes.figure) == ["'far outside' is cut off"]


def test_a_figure_that_a_test_draws_is_checked():
    with pytest.raises(AssertionError, match="'one' overlaps 'other'"), readable_figures() as made:
        axes = Figure().subplots()
        for word in ("one", "other"):
            axes.text(0.5, 0.5, word)
    assert made == [axes.figure]


@pytest.mark.parametrize("count", [2, 7, 14])
def test_texts_of_regions_above_each_other_are_apart(assembly, count):
    """Regions in turn along the joint have nearly the same middle."""
    pairs = np.arange(21)
    joint = on_pairs(assembly, pairs)
    joint["point_of_element"] = ("element", pairs % count)
    figure = plot_regions(assembly, joint)
    assert not faults(figure)
    plan, bars = figure.axes
    places = {text.get_text(): text.get_position()[0] for text in plan.texts}
    for text, bar in zip(plan.texts, bars.patches, strict=True):
        assert bar.get_x() + bar.get_width() / 2 == pytest.approx(places[text.get_text()])
    edges = np.sort([[bar.get_x(), bar.get_x() + bar.get_width()] for bar in bars.patches], axis=0)
    assert (edges[:-1, 1] < edges[1:, 0]).all()
    low, high = plan.get_xlim()
    assert low < edges.min() < edges.max() < high


def test_texts_of_all_figures_of_a_study_are_apart(finished, monkeypatch):
    monkeypatch.chdir(finished)
    contents = Contents(load_study(finished), DISPLAYS)
    drawn = {}
    for job in DISPLAYS.jobs(contents, "figure"):
        inputs = [*job.inputs, *map(str, Path("resources/source").glob("*.csv"))]
        of_job = zip(job.artefacts, job.options, job.counterparts, strict=True)
        for artefact, options, counterpart in of_job:
            source = ThesisComparison.among(inputs, counterpart)
            content = DISPLAYS.of(artefact).content
            drawn[artefact.path] = content(artefact, Results(inputs), options, source)
    assert {path for path in drawn if Path(path).exists()} == set(contents.files(form="figure"))
    found = {path: faults(figure) for path, figure in drawn.items()}
    assert not {path: words for path, words in found.items() if words}
