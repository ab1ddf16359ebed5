import numpy as np
import pandas as pd
from page_examples import CASE, ROOT, edit, plain, results_of, rows_of, source_of

from boltjoint.config.case import Case
from boltjoint.config.study import load_study
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.pages.overview import overview_page
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.stage_inputs import Results


def _figures_and_tables(study):
    contents = Contents(study, DISPLAYS)
    return contents.select(form="figure") + contents.select(form="table")


def test_index_says_where_the_source_stands_and_why_not(artefacts):
    study = load_study(ROOT)
    text = overview_page(study, [], _figures_and_tables(study), Results([]), source_of())
    assert "three_bolt_constant.html#response_three_bolt_constant_free-4_node-to-node" in text
    assert 'four_bolt_variable.html#table-3.21-3.22-free-4"' in text
    assert "not made: explains the method and holds no data" in text
    alone = study.model_copy(update={"cases": {"mine": Case.model_validate(CASE)}})
    text = overview_page(alone, [], artefacts, Results([]), source_of())
    assert "no case of this study is compared with it" in text
    assert "not computed in this study" in text


def overview_of_three(artefacts):
    """The page of a study of which one case of three has results."""
    case = Case.model_validate(CASE)
    study = load_study(ROOT)
    study = study.model_copy(update={"cases": dict.fromkeys(("mine", "second", "third"), case)})
    return overview_page(study, artefacts, artefacts, results_of(artefacts), source_of())


def test_many_cases_are_rows_of_a_table_in_place_of_sentences(artefacts):
    page = overview_of_three(artefacts)
    assert 'class="answers"' not in page
    (row,) = (
        row for row in rows_of(page, "What each joint does, in free-4") if row and row[0] == "mine"
    )
    accuracy = Artefact("accuracy", "table", case="mine", basis="free-4").path
    first, last = pd.read_csv(accuracy).query("resonance == 1").iloc[[0, 1]].to_dict("records")
    # sticking and without contact; then force, frequency and response, each with its bar
    assert row[1:3] == ["102", "70.6"] and "What each joint does, in free-4" in page
    for place, force, peak in ((3, "0.001 N", first), (8, "50 N", last)):
        frequency, response = f"{peak['peak_frequency_Hz']:.2f}", f"{peak['peak_mm_per_N']:g}"
        cells = [force, frequency, "not tested", response, "not tested"]
        assert [plain(cell) for cell in row[place : place + 5]] == cells


def test_the_table_of_joints_leaves_out_peaks_beyond_the_model(artefacts):
    edit(
        "accuracy",
        lambda table: table.assign(
            displacement_over_length_percent=np.where(table["force_N"] == 50, 30.0, 0.1)
        ),
    )
    page = overview_of_three(artefacts)
    (row,) = (row for row in rows_of(page, "What each joint does, in free-4") if row)
    cells = [plain(cell) for cell in row]
    # the last is where the model ends
    assert cells.index("0.001 N") == 3 and cells.index("50 N") == len(cells) - 1
    assert "lowest force whose peak is beyond" in plain(page)
