"""CSV files of numbers with one line of names: tables of designs, and maps of a gap.

Commas separate the cells, or semicolons; then numbers have decimal commas, as spreadsheets of many
languages write them. A byte-order mark, any ends of lines and blank lines at the end mean nothing.
"""

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.config.strict_yaml import DECIMAL, LARGEST, LIMITS, SMALLEST, as_text, as_word
from boltjoint.regular_file import UnsuitableFile, read_bytes

Array = NDArray[np.float64]

#: bytes of a file: several million rows
LARGEST_TABLE = 100_000_000
#: values of a column that a message tells
_TOLD = 10
#: rows that are converted at once
_ROWS = 10_000
#: as many lines of so many numbers as are converted at once; no part is tried in another way
_NUMBER = f"(?>{DECIMAL.pattern})"
_LINES = "(?:{number}(?:,{number}){{{more}}}\n){{1,{rows}}}+"
_SPACES = " \t"
#: a point is part of no number whose decimals follow a comma
_COMMAS_AS_POINTS = str.maketrans(",.", ".,")


class TableError(ValueError):
    """What is wrong with a table."""


class Row(NamedTuple):
    """The cells of a line, by its number in the file."""

    line: int
    cells: list[str]


def read_file(path: str | Path, folder: str | Path | None = None) -> str:
    """The text of a CSV file.

    Parameters
    ----------
    path, folder
        The file, and the folder in which it must lie (``regular_file.read_bytes``).

    Raises
    ------
    OSError
        If the file cannot be read.
    UnsuitableFile
        If it is unsuitable (``regular_file``, with ``LARGEST_TABLE``), or is not UTF-8.
    """
    try:
        return read_bytes(path, LARGEST_TABLE, folder).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise UnsuitableFile(path, "is not text in UTF-8: save it as CSV in UTF-8") from None


class CsvTable:
    """The text of a CSV file as columns of numbers.

    Parameters
    ----------
    text, file
        What the file holds, and its name.

    Attributes
    ----------
    keys
        The names in the first line.

    Raises
    ------
    TableError
        If the first line is no CSV.
    ValueError
        If an argument is no text.
    """

    def __init__(self, text: str, file: str) -> None:
        checks.instance("text", text, str)
        checks.instance("file", file, str)
        self.file = file
        self._lines = StringIO(text.removeprefix("\ufeff"), newline=None)
        first = self._lines.readline()
        self._lines.seek(0)
        if "\t" in first and "," not in first and ";" not in first:
            self._refuse(1, "must have commas or semicolons between cells, not tabs")
        if first.lower().startswith("sep="):
            self._refuse(1, "must have the names of the columns: delete the line sep=")
        self._has_decimal_commas = ";" in first and "," not in first
        self._rows = self._read_rows()
        self.keys = [key.strip(_SPACES) for key in next(self._rows, Row(1, [])).cells]

    def columns(self) -> dict[str, Array]:
        """The numbers of each column, read once.

        Raises
        ------
        TableError
            If the text is no CSV, a line among others is blank, has more or fewer cells than there
            are names, or a cell is no number.
        """
        plain = self._plain_numbers()
        if plain is not None:
            return dict(zip(self.keys, plain.T, strict=True))
        blocks = [np.empty((0, len(self.keys)))]
        while rows := list(islice(self._rows, _ROWS)):
            for row in rows:
                self._require_count(row)
            blocks.append(self._numbers(rows, range(len(self.keys))))
        return dict(zip(self.keys, np.concatenate(blocks).T, strict=True))

    def rows_with(
        self, values: Mapping[str, float | str], names: Sequence[str], most: int
    ) -> tuple[dict[str, Array], list[int]]:
        """The numbers of some columns in the lines where others have a value, read once.

        Parameters
        ----------
        values
            Number or word of columns, by their names; of none for all lines.
        names
            The columns of numbers. Cells of others, and of other lines, may hold anything.
        most
            Number of such lines, at most.

        Returns
        -------
        columns : dict
            By names.
        lines : list of int
            Numbers of the lines.

        Raises
        ------
        TableError
            If the text is no CSV, no line or too many have the values, or a cell is no number.
        """
        told = " and ".join(
            f"{key} {value if isinstance(value, str) else f'{value:g}'}"
            for key, value in values.items()
        )
        told = f" with {told}" if told else ""
        wanted = {self.keys.index(key): value for key, value in values.items()}
        places = [self.keys.index(name) for name in names]
        others: dict[int, dict[str, None]] = {place: {} for place in wanted}
        chosen = []
        for row in self._rows:
            self._require_count(row)
            cells = {place: row.cells[place].strip(_SPACES) for place in wanted}
            if all(self._is(cells[place], value) for place, value in wanted.items()):
                chosen.append(row)
                if len(chosen) > most:
                    raise TableError(f"{self.file}: must have at most {most} rows{told}")
            else:
                for place, cell in cells.items():
                    if len(others[place]) < _TOLD:
                        others[place].setdefault(cell)
        if not chosen:
            there = [
                f"; {self.keys[place]} is {', '.join(map(as_word, cells))}"
                + (", ..." if len(cells) == _TOLD else "")
                for place, cells in others.items()
                if cells
            ]
            raise TableError(f"{self.file}: has no row{told}{''.join(there)}")
        columns = self._numbers(chosen, places).T
        return dict(zip(names, columns, strict=True)), [row.line for row in chosen]

    def _is(self, cell: str, value: float | str) -> bool:
        """Whether a cell holds a number or a word."""
        if isinstance(value, str):
            return cell == value
        written = cell.translate(_COMMAS_AS_POINTS) if self._has_decimal_commas else cell
        return DECIMAL.fullmatch(written) is not None and float(written) == value

    def count(self) -> int:
        """Number of lines below the first, without blank ones at the end, of readable columns."""
        return self._lines.getvalue().rstrip(" \t\n,;").count("\n")

    def _plain_numbers(self) -> Array | None:
        """The numbers by line and column, where all are as programs write them; else None.

        Several times as fast as line by line, which finds what is wrong.
        """
        text = self._lines.getvalue().partition("\n")[2].rstrip("\n") + "\n"
        lines = re.compile(_LINES.format(number=_NUMBER, more=len(self.keys) - 1, rows=_ROWS))
        place, blocks = 0, []
        while place < len(text):
            found = lines.match(text, place)
            if found is None:
                return None
            place = found.end()
            blocks.append(np.fromstring(found[0].rstrip("\n").replace("\n", ","), sep=","))
        numbers = np.concatenate(blocks)
        return numbers.reshape(-1, len(self.keys)) if _is_limited(numbers).all() else None

    def _read_rows(self) -> Iterator[Row]:
        """The lines, without blank ones at the end."""
        delimiter = ";" if self._has_decimal_commas else ","
        reader = csv.reader(self._lines, delimiter=delimiter, strict=True)
        blank = None
        try:
            for cells in reader:
                if not any(map(str.strip, cells)):
                    blank = blank or reader.line_num
                elif blank is not None:
                    self._refuse(blank, "must not be blank: other lines follow")
                else:
                    yield Row(reader.line_num, cells)
        except csv.Error as error:
            self._refuse(reader.line_num, f"cannot be read as CSV: {error}")

    def _require_count(self, row: Row) -> None:
        """Refuse a line with more or fewer cells than there are names."""
        if (count := len(row.cells)) != (keys := len(self.keys)):
            hint = ": are these decimal commas? They need semicolons between cells, or points"
            sentence = f"must have {keys} values, as many as keys"
            self._refuse(row.line, sentence + (hint if count == 2 * keys else ""))

    def _numbers(self, rows: list[Row], places: Sequence[int]) -> Array:
        """The numbers of some lines, by line and column."""
        written: Iterable[str] = (row.cells[place] for row in rows for place in places)
        kind = "a number"
        if self._has_decimal_commas:
            written = (cell.translate(_COMMAS_AS_POINTS) for cell in written)
            kind += " without decimal point: semicolons between cells go with decimal commas"
        cells = [cell.strip(_SPACES) for cell in written]
        wrong = (index for index, cell in enumerate(cells) if not DECIMAL.fullmatch(cell))
        first = next(wrong, None)
        if first is None:
            numbers = np.fromiter(map(float, cells), float, len(cells))
            is_limited = _is_limited(numbers)
            if is_limited.all():
                return numbers.reshape(-1, len(places))
            first, kind = int(np.argmin(is_limited)), LIMITS
        index, column = divmod(first, len(places))
        line, texts = rows[index]
        place = places[column]
        self._refuse(line, f"{self.keys[place]}: {as_text(texts[place])} must be {kind}")

    def _refuse(self, line: int, sentence: str) -> NoReturn:
        raise TableError(f"{self.file}:{line}: {sentence}")


def _is_limited(numbers: Array) -> NDArray[np.bool_]:
    size = abs(numbers)
    return (size == 0) | ((size >= SMALLEST) & (size <= LARGEST))
