"""Lines of a deck of Abaqus or CalculiX as blocks: keywords, options, and numbers in data lines.

Keywords, options and names are told apart by their letters alone, not by capitals. Included files
stand where they are named, so that a block may begin in one file and go on in the next; meshes of
other formats stand there as lines of a deck.
"""

import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from os.path import normpath
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.regular_file import read_bytes, require_regular
from boltjoint.structure.makers.deck.mesh_file import is_mesh, lines_of_mesh

#: bytes of a file: more than 10 million nodes
LARGEST = 2**31
#: files within files, beyond which they are taken for a circle
_DEEPEST = 20
#: commas between options, but not those within quotes
_COMMA = re.compile(r',(?=(?:[^"]*"[^"]*")*[^"]*$)')
_INCLUDE = re.compile(rb"^[ \t]*\*[ \t]*include\b[^\r\n]*", re.IGNORECASE | re.MULTILINE)
#: options by which data lines of a keyword stand in a file of their own
_WITH_INPUT = ("NODE", "ELEMENT", "INCLUDE")


class Place(NamedTuple):
    """A line of a file of a deck; 0 stands for the whole file."""

    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.file}, line {self.line}" if self.line else self.file


@dataclass(eq=False)
class Block:
    """A keyword with its data lines.

    Attributes
    ----------
    keyword
        In capitals, words apart by one blank.
    options
        Values as written, by names in capitals; empty where an option has none.
    place
        Of the keyword.
    rows
        Data lines without blanks at their ends.
    """

    keyword: str
    options: dict[str, str]
    place: Place
    rows: list[str] = field(default_factory=list)
    _lines: list[int] = field(default_factory=list)
    _starts: list[int] = field(default_factory=list)
    _files: list[str] = field(default_factory=list)

    def add(self, row: str, file: str, line: int) -> None:
        """Add a data line."""
        if not self._files or self._files[-1] != file:
            self._starts.append(len(self.rows))
            self._files.append(file)
        self.rows.append(row)
        self._lines.append(line)

    def place_of(self, row: int) -> Place:
        """Place of a data line, or of the keyword where there is no such line."""
        if not 0 <= row < len(self.rows):
            return self.place
        return Place(self._files[bisect_right(self._starts, row) - 1], self._lines[row])

    def refused(self, sentence: str, row: int | None = None) -> ValueError:
        """An error of one line: place, keyword and what is wrong."""
        place = self.place if row is None else self.place_of(row)
        return ValueError(f"{place}: *{self.keyword}: {sentence}")

    def option(self, name: str) -> str:
        """An option that must be there."""
        if not self.options.get(name):
            raise self.refused(f"{name} is missing")
        return self.options[name]

    def fields(self, row: int) -> list[str]:
        """Values of a data line, apart by commas, without an empty one at its end."""
        values = [field.strip() for field in self.rows[row].split(",")]
        return values[:-1] if len(values) > 1 and not values[-1] else values


def read_blocks(folder: Path, file: str) -> list[Block]:
    """All blocks of a deck and of the files that it includes.

    Parameters
    ----------
    folder
        From which the file is seen, and within which all others lie.
    file
        The deck.

    Raises
    ------
    ValueError
        If a file is missing, or includes itself: file and line in one line.
    """
    blocks: list[Block] = []
    for text, name, line in _lines_of(folder, file, (), None):
        if text.startswith("*"):
            blocks.append(_block(text, Place(name, line)))
        elif blocks:
            blocks[-1].add(text, name, line)
        else:
            place = Place(name, line)
            raise ValueError(f"{place}: a deck begins with a keyword, as *NODE, not with data")
    if not blocks:
        raise ValueError(f"{file} has no keywords: it is no deck")
    return blocks


def included_files(folder: Path, file: str) -> tuple[str, ...]:
    """The deck and all files that it includes, seen from the folder; missing ones are left out."""
    names: list[str] = []
    waiting = [file]
    while waiting:
        name = waiting.pop(0)
        path = folder / name
        if name in names or not path.is_file():
            continue
        names.append(name)
        for line in _INCLUDE.findall(path.read_bytes()):
            options = _options(line.decode("latin-1"))[1]
            if options.get("INPUT"):
                waiting.append(_included(folder, file, name, options["INPUT"]))
    return tuple(names)


def _included(folder: Path, deck: str, file: str, name: str) -> str:
    """An included file as seen from the folder: beside the deck, or beside what includes it."""
    name = name.replace("\\", "/")
    beside = [normpath(Path(other).parent / name) for other in dict.fromkeys((deck, file))]
    return next((path for path in beside if (folder / path).is_file()), beside[0])


def _lines_of(
    folder: Path, file: str, outer: tuple[str, ...], place: Place | None
) -> Iterator[tuple[str, str, int]]:
    """Keywords on one line each and data lines, with file and number of the line."""
    if file in outer or len(outer) > _DEEPEST:
        raise ValueError(f"{place}: *INCLUDE: {file} includes itself")
    path = folder / file
    if place is not None:
        if file.startswith(("/", "..")):
            raise ValueError(f"{place}: *INCLUDE: {file} must lie in the folder of the study")
        if not path.is_file():
            raise ValueError(f"{place}: *INCLUDE: file {file} is missing")
    elif not path.is_file():
        raise ValueError(f"{file} is missing: the deck lies in the folder of the study")
    require_regular(path, LARGEST, folder)
    if is_mesh(path):
        yield from ((text, file, 0) for text in lines_of_mesh(folder, file))
        return
    lines = read_bytes(path, LARGEST, folder).decode("latin-1").splitlines()
    number = 0
    while number < len(lines):
        text = lines[number].strip()
        number += 1
        if not text or text.startswith("**"):
            continue
        start = number
        if text[0] == "*":
            # options go on where a line ends with a comma
            while text.endswith(",") and number < len(lines):
                more = lines[number].strip()
                if more.startswith("*"):
                    break
                text += more
                number += 1
            keyword, options = _options(text)
            if keyword in _WITH_INPUT and (name := options.get("INPUT")):
                if keyword != "INCLUDE":
                    yield text, file, start
                inner = _included(folder, (*outer, file)[0], file, name)
                yield from _lines_of(folder, inner, (*outer, file), Place(file, start))
                continue
            if keyword == "INCLUDE":
                raise ValueError(f"{Place(file, start)}: *INCLUDE: INPUT is missing")
        yield text, file, start


def _options(text: str) -> tuple[str, dict[str, str]]:
    """Keyword and options of a line."""
    keyword, *options = _COMMA.split(text.strip().lstrip("*"))
    values: dict[str, str] = {}
    for option in options:
        name, _, value = option.partition("=")
        if name.strip():
            values[" ".join(name.upper().split())] = value.strip().strip('"').strip()
    return " ".join(keyword.upper().split()), values


def _block(text: str, place: Place) -> Block:
    return Block(*_options(text), place)


Array = NDArray[np.float64]

_REAL = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?")
_WHOLE = re.compile(r"[-+]?\d+")
#: largest number of a node or an element
_LARGEST = 2**62
#: entries of a range
MOST = 10**8


def is_whole(text: str) -> bool:
    """Whether a value is a whole number, else it is a name."""
    return _WHOLE.fullmatch(text) is not None


def real(block: Block, row: int, text: str) -> float:
    """A real number of a data line.

    Raises
    ------
    ValueError
        If it is none: file, line and value.
    """
    if not _REAL.fullmatch(text):
        apart = ": values are apart by commas" if len(text.split()) > 1 else ""
        raise block.refused(f"{text!r} is no number{apart}", row)
    number = float(re.sub("[dD]", "e", text))
    if not np.isfinite(number):
        raise block.refused(f"{text!r} is no finite number", row)
    return number


def whole(block: Block, row: int, text: str) -> int:
    """A whole number of a data line, as ``real``."""
    if not _WHOLE.fullmatch(text):
        apart = ": values are apart by commas" if len(text.split()) > 1 else ""
        raise block.refused(f"{text!r} is no whole number{apart}", row)
    number = int(text)
    if abs(number) > _LARGEST:
        raise block.refused(f"{text!r} is too large a number", row)
    return number


def reals(block: Block, row: int, count: int, start: int = 0) -> list[float]:
    """Real numbers of a data line from a place on, 0 where it has none."""
    values = block.fields(row)[start : start + count] if row < len(block.rows) else []
    numbers = [real(block, row, value) if value else 0.0 for value in values]
    return numbers + (count - len(numbers)) * [0.0]


def numbered_reals(block: Block, columns: int) -> tuple[NDArray[np.int64], Array]:
    """Numbers and real numbers of data lines, as of nodes: shapes (rows,) and (rows, columns)."""
    if not block.rows:
        return np.zeros(0, np.int64), np.zeros((0, columns))
    fast = _table(block.rows, columns + 1)
    if fast is not None:
        return fast[:, 0].astype(np.int64), fast[:, 1:]
    label, value = [], []
    for row in range(len(block.rows)):
        label.append(whole(block, row, block.fields(row)[0]))
        value.append(reals(block, row, columns, 1))
    return np.array(label, np.int64), np.array(value)


def _table(rows: Sequence[str], columns: int) -> Array | None:
    """Data lines that all have as many plain numbers; None where any has not."""
    tokens = ",".join(row.rstrip(", ") for row in rows).split(",")
    if len(tokens) != columns * len(rows):
        return None
    if any(row.count(",") < columns - 1 for row in rows):
        return None
    try:
        table = np.array(tokens, dtype=float).reshape(-1, columns)
    except ValueError:
        return None
    label = table[:, 0]
    is_plain = np.isfinite(table).all() and np.all(abs(label) < 2**53)
    return table if is_plain and np.all(label == np.floor(label)) else None


def wholes(block: Block) -> NDArray[np.int64]:
    """All whole numbers of the data lines, one after another."""
    tokens = [token for row in range(len(block.rows)) for token in block.fields(row) if token]
    try:
        if not any("." in token or "_" in token for token in tokens):
            return np.array(tokens, dtype=np.int64)
    except (ValueError, OverflowError):
        pass
    numbers = [
        whole(block, row, field)
        for row in range(len(block.rows))
        for field in block.fields(row)
        if field
    ]
    return np.array(numbers, np.int64)


def records(block: Block, length: int) -> NDArray[np.int64]:
    """Whole numbers of which each record has a length, over one or more lines each.

    Raises
    ------
    ValueError
        If a record is longer or shorter: file and line where it begins.
    """
    values = [[field for field in block.fields(row) if field] for row in range(len(block.rows))]
    if all(len(line) == length for line in values):
        return wholes(block).reshape(-1, length)
    complete: list[list[int]] = []
    record: list[int] = []
    start = 0
    for row, of_row in enumerate(values):
        start = row if not record else start
        record += [whole(block, row, field) for field in of_row]
        if len(record) == length:
            complete.append(record)
            record = []
        elif len(record) > length:
            break
    if record:
        name = f"element {record[0]}"
        raise block.refused(f"{name} has {len(record) - 1} nodes instead of {length - 1}", start)
    return np.array(complete, np.int64).reshape(-1, length)
