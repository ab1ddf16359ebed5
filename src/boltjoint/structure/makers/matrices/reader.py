"""Variables of a structure from the files of a study, each problem in one line with its place."""

import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any, Unpack
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.io import mminfo, mmread

from boltjoint import checks
from boltjoint.config.error_messages import choice
from boltjoint.config.matrices import Matrices
from boltjoint.config.matrix_modes import UNIVERSAL
from boltjoint.provenance.environment import machine_memory
from boltjoint.regular_file import UnsuitableFile, require_regular
from boltjoint.structure.makers.matrices.matlab_files import matlab_file
from boltjoint.structure.makers.matrices.numpy_files import NpzFile
from boltjoint.structure.makers.matrices.universal_file import UniversalFile
from boltjoint.structure.makers.matrices.variables import (
    Size,
    UnsuitableVariable,
    VariableFile,
    dense_size,
)

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


Array = NDArray[np.float64]

_FILES = {
    ".npz": NpzFile,
    ".mat": matlab_file,
    ".mtx": MatrixMarketFile,
    **dict.fromkeys(UNIVERSAL, UniversalFile),
}

#: bytes that one byte of a compressed file may become (deflate)
_MOST_COMPRESSED = 1032
_GIB = 2**30
#: what the readers of files raise where a file is damaged
_DAMAGED = (
    *(OSError, ValueError, TypeError, KeyError, IndexError, EOFError, RuntimeError, MemoryError),
    *(AttributeError, OverflowError, NotImplementedError, struct.error, zlib.error),
    BadZipFile,
)


class Reader:
    """Variables that a structure is described by.

    Parameters
    ----------
    described
        Names of variables and files.
    folder
        Folder of the study, in which all files lie.
    """

    def __init__(self, described: Matrices, folder: str | Path) -> None:
        checks.instance("described", described, Matrices)
        self._described = described
        self._folder = checks.path("folder", folder)
        self._files: dict[str, VariableFile] = {}

    def place(self, variable: str) -> str:
        """File and name of a variable, as messages begin."""
        return f"{self._described.file_of(variable)}: {variable}"

    def size(self, variable: str) -> Size:
        """What its file declares of a variable.

        Raises
        ------
        ValueError
            If file or variable are not there, hold no numbers, or declare more of them than the
            file and the memory of this machine can hold.
        """
        with self._one_line(variable):
            size = self._file(variable).size(variable)
            largest = self._path(variable).stat().st_size * _MOST_COMPRESSED
            if min((0, *size.shape)) < 0 or len(size.shape) > 3:
                raise UnsuitableVariable(f"has shape {size.shape}")
            if size.memory > largest:
                raise UnsuitableVariable("declares more numbers than its file can hold")
            self.require_memory(variable, size.memory, f"has shape {size.shape}")
        return size

    def require_memory(self, variable: str, needed: float, why: str) -> None:
        """Refuse a variable that needs more memory [byte] than this machine has."""
        memory = machine_memory()
        if needed > memory:
            raise ValueError(
                f"{self.place(variable)} {why}: it needs some {needed / _GIB:.3g} GiB of memory, "
                f"and this machine has {memory / _GIB:.3g} GiB"
            )

    def matrix(self, variable: str, shape: tuple[int, int]) -> sparse.csc_array:
        """A matrix of finite numbers of this shape.

        Raises
        ------
        ValueError
            If it is none.
        """
        size, place = self.size(variable), self.place(variable)
        if size.shape != shape:
            raise ValueError(f"{place} has shape {size.shape}, expected {shape}")
        with self._one_line(variable):
            value: Any = self._file(variable).read(variable)
        if not sparse.issparse(value):
            return sparse.csc_array(checks.array(place, value, shape))
        compressed = sparse.csc_array(value, dtype=float)
        compressed.sum_duplicates()
        wrong = np.flatnonzero(~np.isfinite(compressed.data))
        if wrong.size:
            row = int(compressed.indices[wrong[0]])
            column = int(np.searchsorted(compressed.indptr, wrong[0], side="right")) - 1
            number = compressed.data[wrong[0]]
            raise ValueError(f"{place} must be finite, but is {number:g} at index {row, column}")
        return compressed

    def array(
        self, variable: str, shape: tuple[int, ...], **limits: Unpack[checks.Limits]
    ) -> Array:
        """An array of finite numbers of this shape, as for ``checks.array``.

        One dimension of another program may be two, of which one is 1.
        """
        return checks.array(self.place(variable), self._plain(variable, shape), shape, **limits)

    def numbers(self, variable: str, shape: tuple[int, ...], count: int) -> NDArray[np.int64]:
        """Numbers of ``count`` things, from 0 whatever the first one is in the file."""
        first, place = self._described.first_number, self.place(variable)
        values = checks.array(place, self._plain(variable, shape), shape)
        wrong = values[(values != np.round(values)) | (values < first) | (values >= first + count)]
        if wrong.size:
            raise ValueError(
                f"{place} holds {wrong.flat[0]:g}: it must hold whole numbers from {first} to "
                f"{first + count - 1}, with numbered_from: {first}"
            )
        return values.astype(np.int64) - first

    def whole_numbers(self, variable: str, shape: tuple[int, ...]) -> NDArray[np.int64]:
        """Whole numbers that are not negative, as they are in the file."""
        values = checks.array(self.place(variable), self._plain(variable, shape), shape, at_least=0)
        if (wrong := values[values != np.round(values)]).size:
            raise ValueError(
                f"{self.place(variable)} holds {wrong.flat[0]:g}: it must hold numbers of nodes"
            )
        return values.astype(np.int64)

    def column(self, variable: str, length: int, number: int | None) -> Array:
        """A vector, or a column of a matrix, or a row where only its rows have this length."""
        size, place = self.size(variable), self.place(variable)
        if size.is_vector and number is None:
            return self.array(variable, (length,))
        if len(size.shape) != 2 or length not in size.shape:
            raise ValueError(f"{place} has shape {size.shape}: no dimension has length {length}")
        matrix = self.matrix(variable, size.shape)
        columns = matrix if size.shape[0] == length else matrix.T
        first, count = self._described.first_number, columns.shape[1]
        if number is None or not first <= number < first + count:
            wrong = "" if number is None else f", not {number}"
            raise ValueError(
                f"{place} has shape {size.shape}: column must be from {first} to "
                f"{first + count - 1}{wrong}"
            )
        return columns[:, [number - first]].toarray()[:, 0]

    def _plain(self, variable: str, shape: tuple[int, ...]) -> NDArray:
        size = self.size(variable)
        if prod(size.shape) != prod(shape):
            raise ValueError(f"{self.place(variable)} has shape {size.shape}, expected {shape}")
        with self._one_line(variable):
            value: Any = self._file(variable).read(variable)
        value = value.toarray() if sparse.issparse(value) else value
        is_vector = len(shape) == 1 and size.is_vector and value.ndim
        return value.reshape(-1) if is_vector else value

    def _path(self, variable: str) -> Path:
        return self._folder / self._described.file_of(variable)

    def _file(self, variable: str) -> VariableFile:
        """The file of a variable that is there."""
        name = self._described.file_of(variable)
        if name not in self._files:
            path = self._path(variable)
            require_regular(path, int(machine_memory()), self._folder)
            file = _FILES[path.suffix](path)
            if isinstance(file, UniversalFile):
                file.require_units(self._described.length_unit)
            self._files[name] = file
        names = self._files[name].names()
        if names and variable not in names:
            raise UnsuitableVariable(f"is not there{choice(variable, names)}")
        if not names and variable not in self._own:
            raise UnsuitableVariable("is not there: the file holds one matrix, named under files")
        return self._files[name]

    @property
    def _own(self) -> set[str]:
        """Variables with files of their own."""
        return {file.variable for file in self._described.files}

    @contextmanager
    def _one_line(self, variable: str) -> Iterator[None]:
        """Say in one line why a variable is not read."""
        file, place = self._described.file_of(variable), self.place(variable)
        try:
            yield
        except UnsuitableVariable as error:
            raise ValueError(f"{place} {error}") from error
        except UnsuitableFile as error:
            raise ValueError(f"{file}: {error.sentence}") from error
        except FileNotFoundError:
            where = self._folder.resolve()
            raise ValueError(f"{file}: there is no such file in {where}") from None
        except _DAMAGED as error:
            if str(error).startswith(place):
                raise
            reason = " ".join(str(getattr(error, "strerror", None) or error).split())[:200]
            what = f"{type(error).__name__}: {reason}" if reason else type(error).__name__
            raise ValueError(f"{file}: cannot be read: {what}") from error
