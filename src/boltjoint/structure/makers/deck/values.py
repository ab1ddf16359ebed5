"""Numbers in data lines of decks, exponents as Fortran writes them too."""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.deck.lines import Block

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
    found = [real(block, row, each) if each else 0.0 for each in values]
    return found + (count - len(found)) * [0.0]


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
    tokens = [each for row in range(len(block.rows)) for each in block.fields(row) if each]
    try:
        if not any("." in each or "_" in each for each in tokens):
            return np.array(tokens, dtype=np.int64)
    except (ValueError, OverflowError):
        pass
    found = [
        whole(block, row, each)
        for row in range(len(block.rows))
        for each in block.fields(row)
        if each
    ]
    return np.array(found, np.int64)


def records(block: Block, length: int) -> NDArray[np.int64]:
    """Whole numbers of which each record has a length, over one or more lines each.

    Raises
    ------
    ValueError
        If a record is longer or shorter: file and line where it begins.
    """
    values = [[each for each in block.fields(row) if each] for row in range(len(block.rows))]
    if all(len(each) == length for each in values):
        return wholes(block).reshape(-1, length)
    found: list[list[int]] = []
    record: list[int] = []
    start = 0
    for row, of_row in enumerate(values):
        start = row if not record else start
        record += [whole(block, row, each) for each in of_row]
        if len(record) == length:
            found.append(record)
            record = []
        elif len(record) > length:
            break
    if record:
        name = f"element {record[0]}"
        raise block.refused(f"{name} has {len(record) - 1} nodes instead of {length - 1}", start)
    return np.array(found, np.int64).reshape(-1, length)
