"""A study in which no case is compared with a published one has a report about itself alone."""

import re
import shutil
from pathlib import Path

import pandas as pd
from planned import among, planned
from small_study import CASE, ROOT, VARIABLE, write

#: words of the study that the default cases reproduce
WORDS = re.compile(
    r"\b(thes[ie]s|METU|Middle East|sources?|publish\w*|printed|reproduc\w*|counterpart"
    r"|(Table|Figure|Section)s? 3\.|eq\. 3)",
    re.IGNORECASE,
)


def words_in(path):
    """Its words of that study, with what stands around them."""
    text = re.sub(r"<(style|svg|script).*?</\1>", " ", path.read_text(), flags=re.DOTALL)
    return [text[max(0, m.start() - 40) : m.end() + 20] for m in WORDS.finditer(text)]


def test_no_page_and_no_table_speaks_of_another_study(finished):
    results = finished / "results"
    texts = [*(results / "report").glob("*.html"), *(results / "tables").glob("*.*")]
    assert len(texts) > 40
    assert {path.name: words for path in texts if (words := words_in(path))} == {}


def test_there_is_nothing_to_be_compared_with(finished):
    assert not (finished / "resources").exists()
    assert "published" not in CASE
    for path in (finished / "results/tables").glob("times_*.csv"):
        assert pd.read_csv(path)["cpu_forward_difference_s"].isna().all()


def test_the_report_of_the_workflow_has_no_captions_of_another_study():
    captions = sorted((ROOT / "workflow/report").glob("*.rst"))
    assert len(captions) == 5
    for path in captions:
        alone = re.sub(r"{% if snakemake.input.published %}.*?{% endif %}", "", path.read_text())
        assert not WORDS.search(alone), path


def test_a_case_that_asks_for_it_is_compared_and_the_other_is_not(copied):
    shutil.copytree(ROOT / "resources", copied / "resources")
    write(copied / "config/cases/small.yaml", CASE | {"published": "three_bolt_constant"})
    write(copied / "config/cases/variable.yaml", VARIABLE)
    found = planned(copied)
    # times with forward differences, and tables and pages with published values
    assert among(found, "cases/variable/*") == []
    assert among(found, "cases/small/*/forward_differences.csv")
    assert among(found, "tables/elements_small_*.csv") and among(found, "tables/contact.csv")
    assert not among(found, "tables/elements_variable_*.csv")
    pages = {Path(path).stem for path in among(found, "report/*.html")}
    assert pages == {"overview", "accuracy", "structure", "small"}


def test_no_amplitude_stands_without_its_error(finished):
    """In the same sentence, or in a column of the same table."""
    for path in sorted((finished / "results/report").glob("*.html")):
        page = path.read_text(encoding="utf-8")
        page = re.sub(r"<(svg|style|script).*?</\1>", "", page, flags=re.DOTALL)
        for table in re.findall(r"<table.*?</table>", page, re.DOTALL):
            words = re.sub(r"\s+", " ", re.sub("<.*?>", " ", table))
            if "(mm/N)" in words:
                assert re.search("±|off by|error|not tested", words), (path.name, words[:300])
        text = re.sub(r"<table.*?</table>", "", page, flags=re.DOTALL)
        text = re.sub(r"\s+", " ", re.sub("<.*?>", " ", text))
        for sentence in re.split(r"(?<=[.!?]) ", text):
            if re.search(r"\d.mm/N", sentence):
                assert re.search("±|not tested", sentence), (path.name, sentence)
