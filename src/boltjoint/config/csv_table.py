"""CSV files of numbers with one line of names: tables of designs, and maps of a gap."""

import csv
from collections.abc import Collection
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from boltjoint.config.strict_yaml import as_text

Array = NDArray[np.float64]


class TableError(ValueError):
    """What is wrong with a table."""


def read_rows(text: str) -> tuple[list[str], list[list[str]]]:
    """The names of the columns, and the cells of each further line."""
    rows = list(csv.reader(text.splitlines()))
    return (rows[0], rows[1:]) if rows else ([], [])


def as_columns(keys: list[str], rows: Collection[list[str]], file: str) -> dict[str, Array]:
    """The numbers of each column.

    Raises
    ------
    TableError
        If a line has more or fewer cells than there are names, or a cell is no number.
    """
    for line, row in enumerate(rows, start=2):
        if len(row) != len(keys):
            raise TableError(f"{file}:{line}: must have {len(keys)} values, as many as keys")
        for key, cell in zip(keys, row, strict=True):
            if not _is_number(cell):
                raise TableError(f"{file}:{line}: {key}: {as_text(cell)} must be a number")
    columns = np.array(rows, dtype=float).reshape(-1, len(keys)).T
    return dict(zip(keys, columns, strict=True))


def _is_number(cell: str) -> bool:
    try:
        return isfinite(float(cell))
    except ValueError:
        return False
