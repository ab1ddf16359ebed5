"""The interactive page of a sweep: what it holds, of which designs, and how large it is."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from sweep_examples import GRID_SIZES, KEYS, LEVELS, content_of, sweep_of

from boltjoint import csv_files
from boltjoint.config.sweep import SweepCheck
from boltjoint.report.figures.sweeps import plot_sensitivity
from boltjoint.report.pages.content import address_of_sweep
from boltjoint.report.pages.sweep.page import (
    DEFAULT_LIMITS,
    SweepData,
    by_level,
    sweep_page,
    tabulate_failures,
)
from boltjoint.study.tables import html
from boltjoint.study.tables.sobol_indices import tabulate_sensitivity

KINDS = ("grid", "latin-hypercube", "sobol", "saltelli", "table")


def unpack(text, kind="<f4"):
    return np.frombuffer(base64.b64decode(text), kind)


def page_of(kind, **changed):
    content = content_of(kind, 64)
    indices = tabulate_sensitivity(content) if kind == "saltelli" else None
    return sweep_page("swept", sweep_of(kind), content, indices, **changed)


def words_of(page):
    """The text of a page without its scripts."""
    alone = re.sub(r"<(script|style).*?</\1>|<[^>]*>", " ", page, flags=re.DOTALL)
    return re.sub(r"\s+", " ", alone)


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_says_what_its_designs_are(kind):
    page = page_of(kind)
    words = words_of(page)
    count = content_of(kind, 64)["reason"].size
    assert f"{count} designs:" in words and "6 regions of 7 elements" in words
    assert "at 3 excitation levels" in words
    assert ("Sobol indices" in words) == (kind == "saltelli")
    assert not re.search(r"\b(None|nan|Undefined)\b|{{|{%", words)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({}, "without all harmonics"),
        ({"observe": ("converged-peaks",)}, "with all harmonics"),
        ({"observe": ("converged-peaks",), "harmonics": 9}, "with up to 9 harmonics"),
    ],
)
def test_a_page_says_what_harmonics_its_peaks_have(keys, words):
    sweep = sweep_of("grid").model_copy(update=keys)
    assert words in words_of(sweep_page("swept", sweep, content_of("grid", 64)))


def test_a_page_says_first_how_far_its_peaks_are_off():
    told = {"peak_frequency_error": 0.004, "peak_amplitude_error": 0.07, "checked_designs": 5}
    content = content_of("sobol", 64)
    content = content.assign(
        {name: ("force", np.full(content.sizes["force"], value)) for name, value in told.items()}
    )
    check = SweepCheck.model_validate({"basis": "enriched-80", "harmonics": 9})
    sweep = sweep_of("sobol").model_copy(update={"error_bars": False, "check": check})
    words = words_of(sweep_page("swept", sweep, content))
    assert "off by up to 0.4 % in frequency and 7 % in amplitude, further than this study" in words
    assert "in the basis enriched-80 with up to 9 harmonics, whose further" in words
    tolerated = words_of(sweep_page("swept", sweep, content, largest_error=0.08))
    assert "7 % in amplitude: the largest errors of 5 designs drawn at random" in tolerated
    # what is predicted tells its part
    predicted = content.assign(
        is_predicted=("design", np.ones(content.sizes["design"], bool)),
        peak_amplitude_regression_error=("force", np.full(content.sizes["force"], 0.04)),
    )
    words = words_of(sweep_page("swept", sweep, predicted))
    assert "that it does not know. In amplitude the first are 2.9 % and the second 4 %" in words
    # of too few designs there is none
    name = "peak_amplitude_regression_error"
    failed = predicted.assign({name: predicted[name] * np.nan})
    words = words_of(sweep_page("swept", sweep, failed))
    assert "7 % in amplitude" in words and "regression" not in words


@pytest.mark.parametrize("kind", ["grid", "sobol"])
def test_designs_beyond_the_model_are_counted(kind):
    content = content_of(kind, 64)
    reached = 0.3 * content["peak_amplitude"] / content["peak_amplitude"].max()
    content = content.assign(
        peak_displacement_over_length=reached, peak_stress_over_strength=reached
    )
    words = words_of(sweep_page("swept", sweep_of(kind), content))
    beyond = int((reached.max("force") > 0.1).sum())
    assert 0 < beyond < content["reason"].size
    told = f"of {beyond} designs. At the largest, the structure moves by 30 % of its length"
    assert "Some peaks are beyond what the model holds" in words
    # stresses below the strength are no problem
    assert words.count("At the largest") == 1 and told in words
    assert "beyond" not in words_of(page_of(kind))


def test_designs_beyond_the_model_are_counted_where_levels_vary():
    content = content_of("sobol", 64).isel(force=0, drop=True)
    content = content.assign(peak_stress_over_strength=2 * (content["reason"] == ""))
    words = words_of(sweep_page("swept", sweep_of("sobol"), content))
    assert "of 64 designs. At the largest, the nominal stress reaches 200 % of the yield" in words


def test_equal_sweeps_have_equal_pages():
    assert page_of("saltelli") == page_of("saltelli")


def test_a_page_loads_nothing():
    page = page_of("grid")
    markup = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert set(re.findall(r'(?:src|href)="([^"]*)"', markup)) == {
        *("data:,", "#", "../../report/overview.html", "../../report/mine.html#sweeps"),
        *("#designs", "#family", "#means", "#failures"),
    }
    assert "default-src 'none'" in page and page.count("* plotly.js v") == 1


def test_a_page_without_a_report_has_no_links_to_it():
    assert "report/" not in words_of(page_of("grid", reported=False))
    assert 'class="pages"' not in page_of("grid", reported=False)


def test_addresses_lead_from_the_report_to_the_page():
    assert address_of_sweep("swept") == "../sweeps/swept/explore.html"


@pytest.mark.parametrize("kind", KINDS)
def test_the_page_holds_keys_and_peaks_of_its_designs(kind):
    content = content_of(kind, 64)
    packed = SweepData(content).packed()
    designs = unpack(packed["designs"], "<i4")
    count = 128 if kind == "saltelli" else content["reason"].size
    assert sorted(designs) == list(range(count))
    frequency = by_level(content, "peak_frequency")[:, designs]
    assert frequency.shape == (len(LEVELS), count)
    found = unpack(packed["peaks"][0]["values"]).reshape(frequency.shape)
    np.testing.assert_allclose(found, frequency, rtol=1e-7)
    assert [each["words"] for each in packed["keys"]] == [name.replace("_", " ") for name in KEYS]
    assert [each["log"] for each in packed["keys"]][:2] == [False, True]
    # the frequency of a peak follows from the keys of the same design
    load, friction = (unpack(each["values"]).astype(float) for each in packed["keys"][:2])
    np.testing.assert_allclose(
        found[-1], 70 + load / 1e3 * (1 - 1 / (1 + 10 * friction)), rtol=1e-6
    )


def test_responses_are_those_of_the_first_designs():
    content = content_of("grid")
    packed = SweepData(content, limits=replace(DEFAULT_LIMITS, responses=7, frequencies=9)).packed()
    responses = packed["responses"]
    assert responses["designs"] == 7
    shape = len(LEVELS), 7, 9
    found = unpack(responses["amplitude"]).reshape(shape)
    designs = unpack(packed["designs"], "<i4")[:7]
    whole = by_level(content, "response_amplitude")
    assert whole.shape == (3, np.prod(GRID_SIZES), 41)
    np.testing.assert_allclose(found, 1e3 * whole[:, designs, ::5], rtol=1e-6)
    bands = unpack(responses["bands"]).reshape(3, 5, 9)
    np.testing.assert_allclose(bands[:, 2], 1e3 * np.median(whole, axis=1)[:, ::5], rtol=1e-6)


def test_a_sweep_over_levels_has_one_level_of_its_own():
    content = content_of("grid").isel(force=0).drop_vars("force_level")
    data = SweepData(content)
    assert data.levels == [] and data.packed()["levels"] == []
    page = sweep_page("swept", sweep_of("grid"), content)
    assert "excitation level " not in words_of(page).split("Keys and peaks")[0]
    assert '<input type="range"' not in page
    assert '<input type="range"' in page_of("grid")


def test_of_many_designs_a_subset_is_drawn_and_told():
    content = content_of("latin-hypercube", 20_000)
    page = sweep_page("swept", sweep_of("latin-hypercube", 20_000), content)
    words = words_of(page)
    assert "The page holds 10000 designs, drawn at random from all." in words
    assert "at most 2000, drawn at random" in words
    assert "Single responses are those of 300 designs, drawn at random." in words
    assert len(page) < 8e6


def test_a_page_stays_small_whatever_is_observed():
    limits, levels = DEFAULT_LIMITS, 20
    values = limits.numbers + limits.amplitudes + 5 * levels * limits.frequencies
    # four bytes are 16/3 letters; beside them the page has 5 MB of plotly.js
    assert values * 16 / 3 < 5e6
    content = content_of("grid")
    few = SweepData(content, limits=replace(limits, numbers=200, amplitudes=1000))
    # three keys, two peaks at three levels and the number of the design
    assert (few.designs.size, few.responses) == (20, 8)


def test_indices_have_their_level_and_peak():
    content = content_of("saltelli", 64)
    table = tabulate_sensitivity(content)
    rows = SweepData(content, table).packed()["indices"]
    assert len(rows) == 2 * len(LEVELS) * len(KEYS)
    for row, (_, expected) in zip(rows, table.iterrows(), strict=True):
        assert row["peak"] == ["peak_frequency_Hz", "peak_mm"].index(expected["observed"])
        assert LEVELS[row["level"]] == expected["force_N"]
        assert row["total"] == [expected[f"total{end}"] for end in ("", "_low", "_high")]


def test_indices_of_levels_of_many_digits_have_their_places(tmp_path):
    levels = [10.123456789012, 10.123456789013, 1 / 3]
    content = content_of("saltelli", 64).assign_coords(
        force_level=("force", levels, {"units": "N"})
    )
    table = tabulate_sensitivity(content)
    expected = SweepData(content, table).packed()["indices"]
    html.write(table, tmp_path / "t.csv", tmp_path / "t.html", "Sobol indices")
    written = SweepData(content, csv_files.read(tmp_path / "t.csv")).packed()["indices"]
    assert [row["level"] for row in written] == [row["level"] for row in expected]
    assert [row["level"] for row in written] == 2 * [0, 0, 0, 1, 1, 1, 2, 2, 2]
    # first order and total of each key at each level
    (axes, _) = plot_sensitivity(csv_files.read(tmp_path / "t.csv")).axes
    assert len(axes.patches) == 2 * len(KEYS) * len(levels)


def test_unknown_indices_are_null():
    content = content_of("saltelli", 64)
    table = tabulate_sensitivity(content).assign(total=np.nan)
    text = json.dumps(SweepData(content, table).packed(), allow_nan=False)
    assert '"total": [null, ' in text


def test_failures_are_told_with_their_reasons():
    content = content_of("latin-hypercube", 100, failed=5)
    table = tabulate_failures(content)
    assert list(table["designs"]) == [3, 2]
    assert list(table["reason"]) == ["preload_N: -95 must be > 0", "<step length> below 1e-9"]
    assert list(table["with_peaks"]) == [0, 0]
    assert list(table["first_design"]) == [95, 96]
    load = float(content["preload"][95])
    assert table["keys_of_the_first"][0].startswith(f"preload {load:.0f} N, friction")
    page = sweep_page("swept", sweep_of("latin-hypercube"), content)
    assert "5 of them are impossible" in words_of(page)
    assert "&lt;step length&gt; below 1e-9" in page


def test_a_branch_that_ends_after_its_peaks_is_told_with_them():
    content = content_of("grid")
    content["reason"][{"preload": 1, "friction_coefficient": 2, "loss_factor": 0}] = "ends"
    table = tabulate_failures(content.assign(reason=content["reason"].astype("U8")))
    assert table.loc[0, ["designs", "with_peaks", "first_design"]].tolist() == [1, 1, 18]


def test_without_failures_there_is_no_table():
    assert tabulate_failures(content_of("grid")).empty
    assert "No design failed." in words_of(page_of("grid"))


@pytest.mark.parametrize(("keys", "title"), [(1, "Peaks over the key"), (0, None)])
def test_few_keys_need_fewer_drawings(keys, title):
    content = content_of("latin-hypercube", 20)
    for name in list(KEYS)[keys:]:
        content[name] = content[name] * 0 + 1
        content[name].attrs["units"] = "1"
    page = sweep_page("swept", sweep_of("latin-hypercube"), content)
    assert 'id="heat-map"' not in page
    assert ('id="slices"' in page) == (title is not None)
    assert title is None or title in words_of(page)


def test_sweeps_of_peaks_only_have_no_responses():
    content = content_of("grid", responses=False)
    page = sweep_page("swept", sweep_of("grid"), content)
    assert SweepData(content).packed()["responses"] is None
    assert 'id="responses"' not in page


def test_without_any_peak_the_page_is_written():
    content = content_of("latin-hypercube", 8, failed=8)
    content["peak_frequency"][:] = np.nan
    content["peak_amplitude"][:] = np.nan
    assert "8 of them are impossible" in words_of(
        sweep_page("swept", sweep_of("latin-hypercube"), content)
    )


def test_the_table_of_indices_may_come_from_a_file(tmp_path):
    content = content_of("saltelli", 64)
    table = tabulate_sensitivity(content)
    table.to_csv(tmp_path / "table.csv", index=False)
    read = pd.read_csv(tmp_path / "table.csv")
    assert len(SweepData(content, read).packed()["indices"]) == len(table)
