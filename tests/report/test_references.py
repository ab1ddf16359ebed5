import pytest
from page_examples import ROOT, SOURCE

from boltjoint.config.study import load_study
from boltjoint.names import PAGES, Basis, JointName, Preload
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.pages.content import (
    address_of,
    anchor_of,
    page_of,
)
from boltjoint.reproduction.comparison import numbers_of_figures
from boltjoint.reproduction.published import Published
from boltjoint.study.artefact_list import Artefact, Contents


@pytest.fixture(scope="module")
def study():
    return load_study(ROOT)


@pytest.fixture(scope="module")
def figures_and_tables(study):
    contents = Contents(study, DISPLAYS)
    return contents.select(form="figure") + contents.select(form="table")


@pytest.mark.parametrize(
    ("artefact", "page"),
    [
        (Artefact("mesh", "figure", assembly="mine"), "structure"),
        (Artefact("natural_frequencies", "table", basis=Basis("free-4")), "structure"),
        (Artefact("contact", "table"), "structure"),
        (Artefact("contact", "figure", assembly="mine", preload_N=Preload.of(1e20)), "structure"),
        (Artefact("sampling", "figure"), "accuracy"),
        (Artefact("patterns", "table", assembly="mine"), "accuracy"),
        (Artefact("bases", "figure", case="mine"), "accuracy"),
        (Artefact("divisions", "table", case="mine", basis=Basis("enriched-40")), "accuracy"),
        (Artefact("fits", "table", case="mine", basis=Basis("enriched-40")), "mine"),
        (Artefact("backbone", "figure", case="mine", basis=Basis("free-4"), resonance=2), "mine"),
        (Artefact("harmonic_peaks", "table", case="mine", basis=Basis("free-4")), "mine"),
    ],
)
def test_the_page_follows_from_what_a_figure_or_table_is_of(artefact, page):
    assert page_of(artefact) == page


def test_every_figure_and_table_of_the_study_has_a_target_on_a_page(study, figures_and_tables):
    # the overview shows those of other pages
    pages = {*PAGES, *study.cases} - {"overview"}
    assert {page_of(each) for each in figures_and_tables} == pages
    targets = [(page_of(each), anchor_of(each)) for each in figures_and_tables]
    assert len(set(targets)) == len(targets)


def test_a_figure_and_a_table_of_one_name_differ_in_anchor_and_address():
    which = {"case": "a_free-4", "basis": Basis("free-8"), "joint": JointName("regions=6")}
    figure, table = (Artefact("regions", form, **which) for form in ("figure", "table"))
    stem = "regions_a_free-4_free-8_regions=6"
    assert (anchor_of(figure), anchor_of(table)) == (stem, f"{stem}-table")
    assert address_of(figure) == f"../figures/{stem}.svg"
    assert address_of(table) == f"../tables/{stem}.csv"


def test_the_study_has_every_figure_of_the_source_that_can_be_made(study, figures_and_tables):
    found = set()
    for artefact in figures_and_tables:
        case = study.cases.get(artefact.case)
        of_case = Published(SOURCE, case.published if case else None)
        found.update(numbers_of_figures(artefact, of_case))
    index = Published(SOURCE).figures()
    assert found == set(index.loc[index["not_made"] == "", "figure"])
