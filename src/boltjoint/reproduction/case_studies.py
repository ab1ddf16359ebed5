"""Case studies and tables of the source, as every run of the workflow reads them: no pandas."""

import csv
from pathlib import Path

from boltjoint import checks
from boltjoint.config.types import ConfigError

#: files of a folder of published tables: its case studies, and its index of all tables
CASE_STUDIES = "case_studies.csv"
INDEX = "tables.csv"

#: files of the folder that are no table of the source: the indices, and frequencies in its figures
_BESIDE_TABLES = (INDEX, "figures.csv", "natural_frequencies.csv")

#: kinds of tables of times, which are of joints around the first resonance
_TIMES = ("times", "reductions")


def name_case_studies(folder: Path | None) -> list[str]:
    """Names of the case studies among published tables; none without their folder.

    Raises
    ------
    ConfigError
        If the file of case studies cannot be read.
    """
    return [] if folder is None else _column(checks.path("folder", folder) / CASE_STUDIES, "case")


def name_tables(index: str | Path) -> list[str]:
    """Names of all files of published tables, by their index; none without an index.

    Raises
    ------
    ConfigError
        If the index cannot be read.
    """
    index = checks.path("index", index)
    if not index.is_file():
        return []
    return sorted({*_BESIDE_TABLES, *(f"{name}.csv" for name in _column(index, "file"))})


def name_timed_joints(index: str | Path) -> dict[str, list[str]]:
    """Names of the joints with published solution times by the case study, by the index of tables.

    Raises
    ------
    ConfigError
        If the index cannot be read.
    """
    index = checks.path("index", index)
    timed: dict[str, list[str]] = {}
    if index.is_file():
        columns = (_column(index, name) for name in ("case", "kind", "joint"))
        for case, kind, joint in zip(*columns, strict=True):
            if kind in _TIMES:
                timed.setdefault(case, []).append(joint)
    return timed


def _column(path: Path, name: str) -> list[str]:
    """The cells of a column of a CSV file; a ``ConfigError`` if it has none or cannot be read."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = csv.DictReader(file)
            if name not in (rows.fieldnames or ()):
                raise ConfigError([f"{path}: must have a column {name}, as in the project's own"])
            return [row[name] for row in rows]
    except OSError as error:
        raise ConfigError([f"{path}: cannot be read: {error.strerror}"]) from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise ConfigError([f"{path}: cannot be read as CSV: {error}"]) from None
