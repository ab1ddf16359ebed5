from pathlib import Path

import pandas as pd
import pytest

from boltjoint.reproduction.published import Published

SOURCE = Path(__file__).parents[2] / "resources" / "source"


def test_the_index_numbers_every_figure_once():
    numbers = Published(SOURCE).figures()["figure"]
    assert list(numbers) == [f"3.{number}" for number in range(1, 85)]


def test_the_index_names_every_table_once_and_its_file():
    tables = pd.read_csv(SOURCE / "tables.csv", dtype=str)
    assert list(tables["table"]) == [f"3.{number}" for number in range(1, 24)]
    for file in tables["file"]:
        assert (SOURCE / f"{file}.csv").exists()


def test_indexes_name_case_studies_and_assemblies_of_the_source():
    cases = pd.read_csv(SOURCE / "case_studies.csv")
    source = Published(SOURCE)
    assert set(source.figures()["case"]) - {""} == set(cases["case"])
    assert set(source.figures()["assembly"]) - {""} == set(cases["assembly"])
    assert set(source.tables()["case"]) - {""} == set(cases["case"])


def test_a_figure_is_found_by_what_it_shows():
    source = Published(SOURCE, "three_bolt_variable")
    found = source.figures_of("response", joint="node-to-node", coordinates="rdnm-1", resonance=1)
    assert list(found["figure"]) == ["3.45"]
    states = source.figures_of("states", joint="node-to-node", coordinates="linear")
    assert list(states["force_N"]) == ["0.001", "1", "5", "10", "20", "50"]
    contact = source.figures_of("contact", assembly="three_bolt", preload_N=10000)
    assert list(contact["figure"]) == ["3.3", "3.4", "3.44", "3.53"]
    assert source.figures_of("contact", assembly="three_bolt", preload_N=37976).empty


@pytest.mark.parametrize(
    ("case", "joint", "region"),
    [
        ("three_bolt_constant", "regions=6/elements=7", 1),
        ("three_bolt_variable", "regions=12/elements=4", 2),
        ("four_bolt_variable", "regions=16/elements=4", 1),
        (None, "regions=6/elements=7", 1),
    ],
)
def test_the_region_whose_loops_the_source_shows(case, joint, region):
    assert Published(SOURCE, case).region_of_loops(joint) == region


def test_no_case_study_has_no_figures_and_says_nothing():
    source = Published(SOURCE)
    assert source.figures_of("response", joint="node-to-node").empty
    assert source.case_study() == {}
    assert Published(SOURCE, "four_bolt_variable").case_study()["contact_nodes"] == "1693"


def test_slip_forces_imply_nearly_four_times_the_stated_preload():
    assert Published(SOURCE, "three_bolt_constant").implied_preload() == pytest.approx(37976)
    assert Published(SOURCE, "four_bolt_variable").implied_preload() == pytest.approx(
        37465, rel=1e-4
    )
    assert Published(SOURCE, "three_bolt_variable_soft").implied_preload() is None
