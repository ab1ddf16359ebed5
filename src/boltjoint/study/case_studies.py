"""The case studies of the source, as every run of the workflow reads them: without pandas."""

import csv
from pathlib import Path

#: file of a folder of published tables
CASE_STUDIES = "case_studies.csv"


def name_case_studies(folder: Path | None) -> list[str]:
    """Names of the case studies among published tables; none without their folder."""
    if folder is None:
        return []
    with (folder / CASE_STUDIES).open(newline="", encoding="utf-8") as file:
        return [row["case"] for row in csv.DictReader(file)]
