"""What is declared of figures and tables, for every study in ``config/``."""

import pytest
from fresh_imports import modules_loaded_by
from page_examples import ROOT

from boltjoint.checksums import BESIDE
from boltjoint.config.study import load_study
from boltjoint.names import PAGES
from boltjoint.report.displays import DISPLAYS
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import Displays, figure, table


@pytest.fixture(scope="module", params=[None, "convergence", "short", "form_error", "mesh"])
def contents(request):
    changes = {"study": f"config/{request.param}.yaml"} if request.param else {}
    return Contents(load_study(ROOT, changes), DISPLAYS)


def test_every_figure_and_table_is_made_once_from_files_of_the_study(contents):
    files = set(contents.files())
    for form in ("figure", "table"):
        jobs = DISPLAYS.jobs(contents, form)
        assert len({job.name for job in jobs}) == len(jobs)
        made = [each for job in jobs for each in job.artefacts]
        assert sorted(made, key=repr) == sorted(contents.select(form=form), key=repr)
        for job in jobs:
            assert set(job.inputs) <= files
            assert len(job.options) == len(job.artefacts)
            assert not set(job.inputs) & {path for each in job.artefacts for path in each.paths}


def test_whatever_is_declared_is_read_placed_and_worded(contents):
    pages = {*PAGES, *contents.study.cases}
    for artefact in contents.select(form="figure") + contents.select(form="table"):
        display = DISPLAYS.of(artefact)
        for reads in display.reads:
            assert list(reads(contents, artefact)) or display.kind == "accuracy", artefact
        assert display.page_of(artefact) in pages
        for words in (display.title_of(artefact), display.heading_of(artefact)):
            assert words and "{" not in words and "None" not in words
        assert "{" not in display.caption_of(artefact)


def test_declarations_import_neither_compiler_nor_figures():
    loaded = modules_loaded_by(
        "from boltjoint.report.displays import DISPLAYS\nassert len(list(DISPLAYS)) > 20"
    )
    assert not {"numba", "scipy", "matplotlib", "pandas"} & loaded


def declare(form, **changed):
    declared = {
        "of": lambda contents: [{"case": case} for case in contents.study.cases],
        "reads": (lambda contents, one: contents.select("check", case=one.case),),
        "title": "checks of {case}",
        "job": "checks_{case}",
        "options": lambda contents, one: {"factor": contents.study.case(one.case).preload_N},
    }
    return form("checks", **declared | changed)(lambda _, results, factor: factor)


def test_a_declaration_is_all_that_a_new_figure_or_table_needs():
    one, other = declare(figure), declare(table, job="all")
    displays = Displays([one, other])
    contents = Contents(load_study(ROOT), displays)
    (job,) = displays.jobs(contents, "table")
    cases = list(contents.study.cases)
    assert job.name == "all" and [each.case for each in job.artefacts] == cases
    checks = contents.files("check", form="data")
    assert set(job.inputs) == {path for path in checks if not path.endswith(BESIDE)}
    drawn = displays.jobs(contents, "figure")
    assert [each.name for each in drawn] == [f"checks_{case}" for case in cases]
    shown = Artefact("checks", "figure", case=cases[0])
    assert displays.on_page(contents, cases[0]) == [
        shown,
        Artefact("checks", "table", case=cases[0]),
    ]
    assert (shown.path, one.title_of(shown)) == (
        f"results/figures/checks_{cases[0]}.svg",
        f"checks of {cases[0]}",
    )
    assert one.make(shown, None, **drawn[0].options[0]) == contents.study.case(cases[0]).preload_N


def test_two_figures_of_one_name_are_refused():
    with pytest.raises(ValueError, match="two figures called 'checks'"):
        Displays([declare(figure), declare(figure)])
