"""The page of the variables of result files has all those of a study."""

import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
MADE = runpy.run_path(str(DOCS / "variables.py"))
PAGE = (DOCS / "variables.md").read_text(encoding="utf-8")


@pytest.mark.workflow
@pytest.mark.parametrize("kind", list(MADE["kinds"]()), ids=lambda kind: kind[0])
def test_every_variable_of_a_study_is_on_the_page(finished, kind):
    title, pattern = kind
    section = PAGE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    told = [line.strip("| ").split(" | ") for line in section.splitlines()[3:] if line]
    told = {(name, unit, meaning) for name, _, unit, meaning in told}
    files = sorted(finished.glob(pattern))
    assert files or title in ("calibration.nc", "prediction.nc")
    stored = {
        (f"`{name}`", unit, meaning)
        for file in files
        for name, _, unit, meaning in MADE["rows_of"](file)
        if not meaning.startswith("labels")
    }
    assert stored - told == set()
