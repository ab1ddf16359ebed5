from page_examples import CASE, ROOT, source_of

from boltjoint.config.case import Case
from boltjoint.config.study import load_study
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.pages.overview import overview_page
from boltjoint.study.artefact_list import Contents
from boltjoint.study.results import Results


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
