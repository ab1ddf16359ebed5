"""Case studies and tables of the source, as every run of the workflow reads them: no pandas."""

import csv
from pathlib import Path

#: files of a folder of published tables: its case studies, and its index of all tables
CASE_STUDIES = "case_studies.csv"
INDEX = "tables.csv"

#: files of the folder that are no table of the source: the indices, and frequencies in its figures
_BESIDE_TABLES = (INDEX, "figures.csv", "natural_frequencies.csv")


def name_case_studies(folder: Path | None) -> list[str]:
    """Names of the case studies among published tables; none without their folder."""
    if folder is None:
        return []
    return _column(folder / CASE_STUDIES, "case")


def name_tables(index: str | Path) -> list[str]:
    """Names of all files of published tables, by their index; none without an index."""
    index = Path(index)
    if not index.is_file():
        return []
    return sorted({*_BESIDE_TABLES, *(f"{name}.csv" for name in _column(index, "file"))})


def _column(path: Path, name: str) -> list[str]:
    with path.open(newline="", encoding="utf-8") as file:
        return [row[name] for row in csv.DictReader(file)]
