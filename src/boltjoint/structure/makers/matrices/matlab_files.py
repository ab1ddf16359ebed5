"""Variables of MATLAB's ``.mat`` files: version 5, dense or sparse, and 7.3, which is HDF5.

Every length that a file declares is compared with what is there, so that a damaged file is refused
and does not end the process.

References
----------
The MathWorks: MAT-File Format (2023), Level 5.
"""

import zlib
from collections.abc import Iterator
from functools import cached_property
from math import prod
from pathlib import Path
from typing import NamedTuple

import netCDF4
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.structure.makers.matrices.variables import (
    Size,
    UnsuitableVariable,
    VariableFile,
    columns_or_rows,
    dense_size,
    require_numbers,
)

_HEADER, _TAG = 128, 8
_MATRIX, _COMPRESSED = 14, 15
#: types of numbers by their code
_TYPES = dict(
    zip((1, 2, 3, 4, 5, 6, 7, 9, 12, 13), "i1 u1 i2 u2 i4 u4 f4 f8 i8 u8".split(), strict=True)
)
#: classes of arrays by their code
_CLASSES_OF_VERSION_5 = {
    1: "cell",
    2: "struct",
    3: "object",
    4: "char",
    5: "sparse",
    16: "function",
}
_SPARSE, _NUMBERS = 5, range(6, 16)
_COMPLEX, _LOGICAL = 0x0800, 0x0200
#: bytes in which flags, dimensions and a name of 63 letters lie
_HEAD = 512


class DamagedMatFile(ValueError):
    """A file that is not what MATLAB writes."""


class Element(NamedTuple):
    """Code of the type, place and bytes of an element, and where the next one begins."""

    code: int
    start: int
    size: int
    after: int


class Head(NamedTuple):
    """A variable, as its first bytes describe it; ``element`` is where the file holds it."""

    shape: tuple[int, ...]
    kind: int
    flags: int
    stored: int
    element: Element


class Mat5File:
    """A file of version 5."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with open(path, "rb") as file:
            order = file.read(_HEADER)[-2:]
        if order not in (b"IM", b"MI"):
            raise DamagedMatFile("is no MATLAB file of version 5 or 7.3")
        self._order = "<" if order == b"IM" else ">"

    def names(self) -> list[str]:
        return sorted(self._heads)

    def size(self, name: str) -> Size:
        head = self._head(name)
        if head.kind == _SPARSE:
            return Size(head.shape, head.stored, is_sparse=True)
        return dense_size(head.shape)

    def read(self, name: str) -> NDArray | sparse.sparray:
        head = self._head(name)
        content = self._content(head)
        # after flags, dimensions and name
        parts = [self._numbers(content, element) for element in list(self._elements(content))[3:]]
        if head.kind != _SPARSE:
            if len(parts) != 1 or parts[0].size != prod(head.shape):
                raise DamagedMatFile("holds another number of entries than it declares")
            return parts[0].reshape(head.shape, order="F")
        if len(parts) != 3 or not parts[1].size:
            raise DamagedMatFile("is no sparse matrix")
        row, start, values = parts
        # a file may have room for more
        stored = int(start[-1])
        return columns_or_rows(values[:stored], row[:stored], start, head.shape, "csc")

    @cached_property
    def _heads(self) -> dict[str, Head]:
        heads, place = {}, _HEADER
        end = self._path.stat().st_size
        with open(self._path, "rb") as file:
            while place < end:
                file.seek(place)
                element = self._element(file.read(_TAG), 0, end - place)
                # matrices that are compressed are not padded
                is_packed = element.code == _COMPRESSED
                after = place + (_TAG + element.size if is_packed else element.after)
                if element.code not in (_MATRIX, _COMPRESSED):
                    raise DamagedMatFile(f"has an element of type {element.code}")
                start = file.read(min(element.size, _HEAD))
                if is_packed:
                    start = zlib.decompressobj().decompress(start, _HEAD)[_TAG:]
                name, head = self._described(start, element._replace(start=place + _TAG))
                heads[name] = head
                place = after
        # what MATLAB keeps for itself
        heads.pop("", None)
        return heads

    def _described(self, content: bytes, element: Element) -> tuple[str, Head]:
        """Name and head of a matrix, of its first bytes."""
        flags = self._element(content, 0)
        words = np.frombuffer(content, f"{self._order}u4", 2, flags.start)
        kind, bits = int(words[0]) & 0xFF, int(words[0])
        # what is stored otherwise has no dimensions
        following = self._element(content, flags.after)
        if kind not in (*_CLASSES_OF_VERSION_5, *_NUMBERS):
            return self._text(content, following), Head((), kind, bits, 0, element)
        shape = tuple(int(size) for size in self._numbers(content, following))
        name = self._text(content, self._element(content, following.after))
        return name, Head(shape, kind, bits, int(words[1]), element)

    def _head(self, name: str) -> Head:
        """The head of a matrix of real numbers."""
        head = self._heads[name]
        if head.kind not in (_SPARSE, *_NUMBERS):
            kind = _CLASSES_OF_VERSION_5.get(head.kind, "opaque")
            raise UnsuitableVariable(f"is of class {kind}: it must be a matrix of real numbers")
        for flag, what in ((_COMPLEX, "complex"), (_LOGICAL, "booleans")):
            if head.flags & flag:
                raise UnsuitableVariable(f"holds {what}: it must hold real numbers")
        return head

    def _content(self, head: Head) -> bytes:
        with open(self._path, "rb") as file:
            file.seek(head.element.start)
            content = file.read(head.element.size)
        if len(content) < head.element.size:
            raise DamagedMatFile("ends before its variables do")
        if head.element.code != _COMPRESSED:
            return content
        packed = zlib.decompressobj()
        is_sparse = head.kind == _SPARSE
        entries = head.stored + sum(head.shape) if is_sparse else prod(head.shape)
        # of eight bytes at most, beside their places in a sparse matrix
        most = _HEAD + 16 * entries
        content = packed.decompress(content, most)
        if not packed.eof:
            raise DamagedMatFile("holds another number of entries than it declares")
        return content[_TAG:]

    def _elements(self, content: bytes) -> Iterator[Element]:
        place = 0
        while place < len(content):
            element = self._element(content, place)
            yield element
            place = element.after

    def _element(self, content: bytes, place: int, end: int | None = None) -> Element:
        """The element that begins at a place of what reaches to an end."""
        end = len(content) if end is None else end
        if len(content) < place + _TAG:
            raise DamagedMatFile("ends within a variable")
        code, size = (
            int(number) for number in np.frombuffer(content, f"{self._order}u4", 2, place)
        )
        start = place + _TAG
        if code >> 16:
            # a short one lies in its tag
            size, code, start = code >> 16, code & 0xFFFF, place + _TAG // 2
            if size > _TAG // 2:
                raise DamagedMatFile("has a short element that is too long")
        if start + size > end:
            raise DamagedMatFile("ends before its variables do")
        padded = -(-size // _TAG) * _TAG if start == place + _TAG else 0
        return Element(code, start, size, place + _TAG + padded)

    def _numbers(self, content: bytes, element: Element) -> NDArray:
        if element.code not in _TYPES:
            raise DamagedMatFile(f"has an element of type {element.code}")
        dtype = np.dtype(f"{self._order}{_TYPES[element.code]}")
        count, rest = divmod(element.size, dtype.itemsize)
        if rest:
            raise DamagedMatFile("has an element of another length than its numbers")
        return np.frombuffer(content, dtype, count, element.start)

    def _text(self, content: bytes, element: Element) -> str:
        return content[element.start : element.start + element.size].decode("ascii", "replace")


_HDF5 = b"\x89HDF\r\n\x1a\n"
#: bytes before HDF5 begins, which MATLAB writes
_USER_BLOCK = 512
#: of arrays of numbers
_WHOLE = (f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
_CLASSES = ("double", "single", *_WHOLE)


def matlab_file(path: Path) -> VariableFile:
    """A ``.mat`` file by its version."""
    with open(path, "rb") as file:
        first = file.read(_USER_BLOCK + len(_HDF5))
    is_hdf5 = first.startswith(_HDF5) or first.endswith(_HDF5)
    return MatHdf5File(path) if is_hdf5 else Mat5File(path)


def _require_class(kind: str) -> None:
    if kind not in _CLASSES:
        raise UnsuitableVariable(f"is of class {kind}: it must be a matrix of real numbers")


class MatHdf5File:
    """A file of version 7.3: arrays with their dimensions reversed, groups of sparse matrices."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def names(self) -> list[str]:
        with netCDF4.Dataset(self._path) as file:
            # MATLAB's own begin with #
            return sorted(name for name in (*file.variables, *file.groups) if name[0] != "#")

    def size(self, name: str) -> Size:
        with netCDF4.Dataset(self._path) as file:
            if name in file.groups:
                group = file.groups[name]
                rows = self._rows(group)
                stored = group.variables["data"].size if "data" in group.variables else 0
                return Size((rows, group.variables["jc"].size - 1), int(stored), is_sparse=True)
            return dense_size(self._checked(file.variables[name]).shape[::-1])

    def read(self, name: str) -> NDArray | sparse.sparray:
        with netCDF4.Dataset(self._path) as file:
            file.set_auto_mask(False)
            file.set_auto_scale(False)
            if name not in file.groups:
                return self._checked(file.variables[name])[...].T
            group = file.groups[name]
            rows, start = self._rows(group), group.variables["jc"][...]
            # not there where all entries are zero
            is_there = "data" in group.variables and "ir" in group.variables
            values = self._numbers(group.variables["data"])[...] if is_there else np.zeros(0)
            row = group.variables["ir"][...] if is_there else np.zeros(0, np.int64)
        return columns_or_rows(values, row, start, (rows, start.size - 1), "csc")

    def _rows(self, group: netCDF4.Group) -> int:
        if "MATLAB_sparse" not in group.ncattrs() or "jc" not in group.variables:
            raise UnsuitableVariable("is a structure: it must be a matrix of real numbers")
        return int(group.getncattr("MATLAB_sparse"))

    def _checked(self, variable: netCDF4.Variable) -> netCDF4.Variable:
        """A variable that is a matrix of numbers."""
        attributes = variable.ncattrs()
        is_named = "MATLAB_class" in attributes
        _require_class(str(variable.getncattr("MATLAB_class")) if is_named else "double")
        if "MATLAB_empty" in attributes and variable.getncattr("MATLAB_empty"):
            raise UnsuitableVariable("is empty")
        return self._numbers(variable)

    def _numbers(self, variable: netCDF4.Variable) -> netCDF4.Variable:
        if not isinstance(variable.datatype, np.dtype):
            names = getattr(getattr(variable.datatype, "dtype", None), "names", None)
            what = "complex" if names and len(names) == 2 else "no numbers"
            raise UnsuitableVariable(f"holds {what}: it must hold real numbers")
        require_numbers(variable.datatype)
        return variable
