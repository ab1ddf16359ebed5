"""Matrices of Matrix Market's ``.mtx`` files."""

from pathlib import Path

from numpy.typing import NDArray
from scipy import sparse
from scipy.io import mminfo, mmread

from boltjoint.structure.makers.matrices.variables import Size, UnsuitableVariable, dense_size

#: fewest bytes of an entry: a digit and the end of its line, and two numbers of its place before it
_DENSE, _SPARSE = 2, 6


class MatrixMarketFile:
    """A file of one matrix, without a name."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def names(self) -> list[str]:
        return []

    def size(self, name: str) -> Size:
        rows, columns, entries, form, field, symmetry = mminfo(str(self._path))
        if field not in ("real", "double", "integer", "unsigned-integer"):
            raise UnsuitableVariable(f"holds {field} entries: it must hold real numbers")
        is_sparse = form == "coordinate"
        # of a symmetric one a triangle stands for both
        stored = int(entries) if is_sparse else rows * columns // (1 + (symmetry != "general"))
        if stored * (_SPARSE if is_sparse else _DENSE) > self._path.stat().st_size:
            raise UnsuitableVariable("holds fewer entries than it declares")
        if not is_sparse:
            return dense_size((rows, columns))
        return Size((rows, columns), stored * (1 + (symmetry != "general")), is_sparse=True)

    def read(self, name: str) -> NDArray | sparse.sparray:
        self.size(name)
        value = mmread(str(self._path))
        return sparse.csc_array(value) if sparse.issparse(value) else value
