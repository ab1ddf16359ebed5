"""Variables of files: their sizes before anything is read, and arrays or sparse matrices."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

#: kinds of NumPy arrays that hold numbers
_NUMBERS = "iuf"
#: bytes of a number, and of its place in a sparse matrix
_NUMBER, _PLACE = 8, 4


class UnsuitableVariable(ValueError):
    """Why a variable is not read: a sentence without a subject."""


@dataclass(frozen=True)
class Size:
    """What a file declares of a variable.

    ``shape``, and ``stored``, the number of entries that the file holds: fewer than the product of
    the shape in a sparse matrix.
    """

    shape: tuple[int, ...]
    stored: int
    is_sparse: bool = False

    @property
    def memory(self) -> int:
        """Of the variable once it is read [byte]."""
        # a dense matrix becomes a sparse one
        return self.stored * (_NUMBER + (_PLACE if self.is_sparse else 0))

    @property
    def is_vector(self) -> bool:
        """Whether at most one dimension is longer than 1."""
        return sum(length > 1 for length in self.shape) < 2


class VariableFile(Protocol):
    """A file of variables."""

    def names(self) -> list[str]:
        """Names of its variables; none where it holds one without a name."""

    def size(self, name: str) -> Size:
        """What the file declares of a variable that is there."""

    def read(self, name: str) -> NDArray | sparse.sparray:
        """A variable that is there."""


def dense_size(shape: Sequence[int]) -> Size:
    """Size of an array."""
    return Size(tuple(map(int, shape)), prod(map(int, shape)))


def require_numbers(dtype: np.dtype) -> None:
    """Refuse an array of what is no real number."""
    if dtype.kind in _NUMBERS:
        return
    kinds = {"c": "complex", "U": "text", "S": "text", "O": "Python objects", "b": "booleans"}
    raise UnsuitableVariable(f"holds {kinds.get(dtype.kind, dtype)}: it must hold real numbers")


def columns_or_rows(
    values: NDArray, place: NDArray, start: NDArray, shape: Sequence[int], kind: str
) -> sparse.sparray:
    """A sparse matrix by columns (``csc``) or rows (``csr``), whose indices are all in it.

    Raises
    ------
    UnsuitableVariable
        If they are not.
    """
    kinds = {"csc": sparse.csc_array, "csr": sparse.csr_array}
    require_numbers(values.dtype)
    for numbers in (place, start, np.asarray(shape)):
        if numbers.dtype.kind not in "iu" or numbers.ndim != 1:
            raise UnsuitableVariable("is no sparse matrix: its indices are not whole numbers")
    try:
        parts = values, place.astype(np.int64), start.astype(np.int64)
        matrix = kinds[kind](parts, shape=tuple(map(int, shape)))
        matrix.check_format(full_check=True)
    except ValueError as error:
        raise UnsuitableVariable(f"is no sparse matrix: {error}") from error
    return matrix
