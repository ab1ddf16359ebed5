"""Tables as CSV files with their checksums; excitation levels are read as they were written."""

from collections.abc import Mapping
from io import StringIO
from pathlib import Path

import pandas as pd

from boltjoint import checks, checksums
from boltjoint.checksums import DamagedFile

#: column of the excitation levels, by which rows of several tables and results belong together
_LEVEL = "force_N"
_DIGITS = "%.9g"


def write(table: pd.DataFrame, path: str | Path) -> None:
    """Write data with all digits, the checksum beside the file.

    Parameters
    ----------
    table
        Columns named ``quantity_unit`` in snake case.
    path
        CSV file to write.
    """
    checks.instance("table", table, pd.DataFrame)
    checksums.write_text(path, table.to_csv(index=False))


def write_rounded(table: pd.DataFrame, path: str | Path) -> None:
    """Write numbers with nine significant digits, excitation levels with all; as ``write``."""
    checks.instance("table", table, pd.DataFrame)
    exact = table
    if _LEVEL in table:
        exact = table.assign(**{_LEVEL: table[_LEVEL].map(_all_digits, na_action="ignore")})
    checksums.write_text(path, exact.to_csv(index=False, float_format=_DIGITS))


def read(path: str | Path, dtype: Mapping[str, type] | None = None) -> pd.DataFrame:
    """Read a table of the results, its excitation levels as they were written.

    Parameters
    ----------
    path
        A CSV file.
    dtype
        Types of columns that differ from those that their values suggest.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    DamagedFile
        If the file does not have its checksum (``checksums.read_text``), is empty, ends within a
        row, or is no table.
    """
    if dtype is not None:
        checks.mapping("dtype", dtype)
        for column, kind in dtype.items():
            checks.subclass(f"dtype of {column}", kind, object)
    text = checksums.read_text(path)
    if not text.endswith("\n"):
        raise DamagedFile(path, "is not complete, its last row has no end")
    try:
        return pd.read_csv(StringIO(text), dtype=dtype, converters={_LEVEL: _number})
    except ValueError as error:  # what pandas raises is a ValueError
        raise DamagedFile(path, f"cannot be read ({str(error).strip()})") from error


def _all_digits(number: float) -> str:
    """A number in as many digits as tell it from all others, and in nine if these do."""
    short = _DIGITS % number
    return short if float(short) == number else repr(float(number))


def _number(cell: str) -> float:
    # some versions of pandas read numbers of many digits to the last but one
    return float(cell or "nan")
