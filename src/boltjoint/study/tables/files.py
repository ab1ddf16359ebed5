"""Tables as files: CSV for programs, HTML for readers."""

import html
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from boltjoint.dataset import DamagedFile

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1c2733; margin: 1.5rem; }
h1 { font-size: 1.15rem; margin: 0 0 1rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .7rem; text-align: right; white-space: nowrap; }
th { border-bottom: 2px solid #1c2733; vertical-align: bottom; white-space: normal; }
td { border-bottom: 1px solid #dfe5ec; }
th.text, td.text { text-align: left; }
tr:hover td { background: #f2f6fa; }
"""

#: a column's last words that are its unit, and how the unit is printed
_UNITS = {
    "kN_per_mm": "kN/mm",
    "mm_per_N": "mm/N",
    "dB": "dB",
    "percent": "%",
    "points": "percentage points",
    "relative": "relative",
    "Hz": "Hz",
    "MPa": "MPa",
    "um": "µm",
    "mm": "mm",
    "N2": "N²",
    "N": "N",
    "s": "s",
}


def write(table: pd.DataFrame, csv: str | Path, page: str | Path, title: str) -> None:
    """Write a table as CSV and as an HTML page.

    Parameters
    ----------
    table
        Columns named ``quantity_unit`` in snake case.
    csv, page
        Files to write; numbers in the CSV have nine significant digits.
    title
        Heading of the page.
    """
    table.to_csv(csv, index=False, float_format="%.9g")
    head = "".join(f'<th class="{_kind(table[c])}">{html.escape(heading(c))}</th>' for c in table)
    rows = "\n".join(
        "<tr>"
        + "".join(
            f'<td class="{_kind(table[c])}">{html.escape(_cell(value))}</td>'
            for c, value in zip(table, row, strict=True)
        )
        + "</tr>"
        for row in table.itertuples(index=False)
    )
    Path(page).write_text(
        f"<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
        f"<title>{html.escape(title)}</title><style>{_STYLE}</style></head>\n"
        f"<body><h1>{html.escape(title)}</h1>\n"
        f"<table><thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody></table></body></html>\n",
        encoding="utf-8",
    )


def read(path: str | Path, dtype: Mapping[str, type] | None = None) -> pd.DataFrame:
    """Read a table of the results.

    Parameters
    ----------
    path
        A CSV file.
    dtype
        Types of columns that are not as their values look.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    DamagedFile
        If the file is empty, ends within a row, or is no table.
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"{path}: there is no such file")
    try:
        if not path.read_bytes().endswith(b"\n"):
            raise DamagedFile(path, "is not complete, its last row has no end")
        return pd.read_csv(path, dtype=dtype)
    except DamagedFile:
        raise
    except (OSError, ValueError) as error:  # what pandas raises is a ValueError
        raise DamagedFile(path, f"cannot be read ({str(error).strip()})") from error


def heading(column: str) -> str:
    """What stands above a column: its name in words, its unit in brackets.

    >>> heading("largest_load_N"), heading("k_kN_per_mm"), heading("reason")
    ('largest load (N)', 'k (kN/mm)', 'reason')
    """
    for ending, unit in _UNITS.items():
        if column.endswith(f"_{ending}"):
            words = column.removesuffix(f"_{ending}").replace("_", " ")
            return f"{words} ({unit})"
    return column.replace("_", " ")


def _kind(column: pd.Series) -> str:
    numeric = pd.api.types.is_numeric_dtype(column) and not pd.api.types.is_bool_dtype(column)
    return "number" if numeric else "text"


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None or (isinstance(value, float) and pd.isna(value)):
        return "–"
    if isinstance(value, float):
        return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
    return str(value)
