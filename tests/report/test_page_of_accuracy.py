import re

import pandas as pd
import pytest
from page_examples import CASE, plain, repeated_ids, results_of, save, source_of

from boltjoint.config.case import Case
from boltjoint.names import Basis
from boltjoint.report.pages.accuracy import accuracy_page
from boltjoint.study.artefact_list import Artefact


def accuracy_of(artefacts, case=CASE):
    cases = dict.fromkeys(("mine", "other"), Case.model_validate(case))
    return accuracy_page(artefacts, results_of(artefacts), source_of(), cases)


def test_how_far_one_harmonic_is_off_stands_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    table = pd.DataFrame(
        {
            "force_N": [1.0, 1.0, 10.0, 10.0],
            "harmonics": [1, 9] * 2,
            "peak_frequency_error_percent": [0.3, 0.0, 1.1, 0.0],
            "peak_amplitude_error_percent": [-8.0, 0.0, -40.4, 0.0],
            "amplitude_truncation_error_percent": [None, 0.05, None, 0.31],
        }
    )
    # the basis without contact errs by less, and is not what counts
    frames = {
        Artefact("harmonic_peaks", "table", case="mine", basis=Basis(basis)): table.assign(
            **table.filter(like="peak") * share, basis_amplitude_error_percent=estimate
        )
        for basis, share, estimate in (("free-4", 0.1, None), ("enriched-8", 1.0, 2.37))
    }
    artefacts = [save(each, frame) for each, frame in frames.items()]
    lead = plain(accuracy_of(artefacts).split("</header>")[0])
    assert "largest contact-adapted basis, with as many harmonics as change nothing." in lead
    assert "off by up to 2.4 % by the basis with one harmonic and by up to 0.31 % by har" in lead
    assert "Models with one harmonic put peaks off by up to 40 %" in lead
    assert "off by up to 40 % in amplitude and 1.1 % in frequency" in lead
    assert "at 1, 10 N" in lead
    for each, frame in frames.items():
        save(each, frame.assign(harmonics=[3, 9] * 2))
    lead = plain(accuracy_of(artefacts).split("</header>")[0])
    assert "Models with 3 harmonics put peaks off" in lead
    page = plain(accuracy_of([]))
    assert "errors against the full finite-element model are not tested" in page
    assert "is not known" in page
    # nothing was converged, and nothing claims it
    assert "converge" not in page.replace("converged_peaks: true", "")


def test_a_case_without_reduced_models_is_not_in_their_table(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    reference = {"joint": "node-to-node", "resonance": 1, "complete": True}
    rows = [
        reference | {"coordinates": "linear", "peak_amplitude_error_percent": None},
        reference | {"coordinates": "backbone", "peak_amplitude_error_percent": 2.5},
    ]
    basis, case, tables = Basis("enriched-8"), CASE | {"modes": ["enriched-8"]}, {}
    for name, count in (("mine", 2), ("other", 1)):
        artefact = Artefact("accuracy", "table", case=name, basis=basis)
        tables[name] = save(artefact, pd.DataFrame(rows[:count]))
    page = accuracy_of(list(tables.values()), case)
    assert "is not in it. The tables of bases" in plain(page)
    table = page[page.index("Errors of reduced models") :]
    assert "2.5" in table and "mine.html" in table and "other.html" not in table
    assert "Errors of reduced models" not in accuracy_of([tables["other"]], case)


@pytest.fixture
def page_of_accuracy(tmp_path, monkeypatch):
    """The page of one case that has everything and of another that has nothing."""
    monkeypatch.chdir(tmp_path)
    which = {
        "patterns": {"assembly": "three_bolt"},
        "models": {"case": "mine"},
        "bases": {"case": "mine"},
        "divisions": {"case": "mine", "basis": Basis("enriched-8")},
        "reductions": {"case": "mine", "basis": Basis("enriched-8")},
        "larger_basis": {"case": "mine", "basis": Basis("enriched-8")},
    }
    peak = {"peak_frequency_error_percent": -0.5, "peak_amplitude_error_percent": 2.0}
    rows = {
        "patterns": {
            "basis": ["free-4", "free-4", "enriched-8", "enriched-8"],
            "vectors": [4, 4, 8, 8],
            "springs": "x",
            "pattern": ["all", "left", "all", "left"],
            "resonance": 1,
            "frequency_Hz": 100.0,
            "error_percent": [51.5, 3.0, 0.25, 0.125],
        },
        "models": {
            "modes": ["free-4", "enriched-8"],
            "joint": "node-to-node",
            "coordinates": ["rdnm-1", "linear"],
            "resonance": 1,
            "force_N": 5.0,
            "complete": [False, True],
            **peak,
            "cpu_s": 1.0,
        },
        "bases": {
            "basis": ["free-4", "free-4", "enriched-8"],
            "vectors": [4, 4, 8],
            "force_N": [1.0, 5.0, 1.0],
            **peak,
            "peak_amplitude_error_percent": [-77.0, 12.0, 0.0],
        },
        "divisions": {
            "division": "clusters",
            "motion": "mean",
            "regions": [2, 2, 4],
            "region_error_percent": 1.5,
            "force_N": [1.0, 5.0, 1.0],
            **peak,
        },
        "reductions": {
            "joint": ["node-to-node", "node-to-node", "hyper=20"],
            "points": [300, 300, 20],
            "elements": [300, 300, 20],
            "cpu_s": [0.25, 0.5, 0.125],
            "force_N": [1.0, 5.0, 1.0],
            **peak,
        },
    }
    rows["larger_basis"] = {"force_N": [5.0, 5.0], "harmonics": [1, 9], **peak}
    of_figure = which | {"reductions": {}}
    return accuracy_of(
        [
            save(Artefact(kind, form, **of[kind]), pd.DataFrame(content))
            for form, of in (("figure", of_figure), ("table", which))
            for kind, content in rows.items()
            if (kind, form) != ("larger_basis", "figure")
        ]
    )


def test_page_of_accuracy_has_structure_models_bases_and_regions(page_of_accuracy):
    sections = re.findall('<section id="([^"]+)"', page_of_accuracy)
    assert sections == [
        "reading",
        "patterns",
        "all-reductions",
        *("case-mine", "models-mine", "bases-mine", "divisions-mine", "reductions-mine"),
    ]
    assert len(re.findall("<svg", page_of_accuracy)) == 5
    assert page_of_accuracy.count('href="../tables/') == 6
    assert not repeated_ids(page_of_accuracy)


def test_a_contact_adapted_basis_without_converged_peaks_is_named_and_claims_none(page_of_accuracy):
    page = plain(page_of_accuracy)
    assert "of the largest contact-adapted basis.</strong>" in page
    assert "No basis of this study" not in page
    assert "the error of those that a model leaves out is not in it" in page
    assert "converge (" not in page


def test_page_of_accuracy_sums_up_by_the_largest_errors(page_of_accuracy):
    tables = {
        re.search("<strong>(.*?)</strong>", each)[1]: [
            [re.sub("<.*?>", "", cell) for cell in re.findall("<td.*?</td>", row)]
            for row in re.findall("<tr.*?</tr>", each)
        ][-2:]
        for each in re.findall('<figure class="tabular".*?</figure>', page_of_accuracy, re.S)
        if "Every" not in each
    }
    assert tables["Largest errors in three_bolt, over all patterns"] == [
        ["free-4", "4", "51.50"],
        ["enriched-8", "8", "0.25"],
    ]
    # those of models, bases, regions and reductions; the last one stands here
    assert tables["Largest errors over all forces of reductions: mine"] == [
        ["node-to-node", "300", "300", "0.50", "2.00", "0.75"],
        ["20 weighted pairs", "20", "20", "0.50", "2.00", "0.125"],
    ]
    assert ["free-4", "4", "0.50", "77.00"] in [
        [re.sub("<.*?>", "", cell) for cell in re.findall("<td.*?</td>", row)]
        for row in re.findall("<tr.*?</tr>", page_of_accuracy)
    ]
