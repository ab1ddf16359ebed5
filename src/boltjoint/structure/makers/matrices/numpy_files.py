"""Variables of NumPy's ``.npz`` files: arrays and sparse matrices, without pickled objects."""

from functools import cached_property
from math import prod
from pathlib import Path
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.structure.makers.matrices.variables import (
    Size,
    UnsuitableVariable,
    columns_or_rows,
    dense_size,
    require_numbers,
)

_SUFFIX = ".npy"
#: by the version of the format, what reads the header of an array
_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
#: parts of sparse matrices by their format
_PARTS = {
    "csr": ("data", "indices", "indptr"),
    "csc": ("data", "indices", "indptr"),
    "coo": ("data", "row", "col"),
}


class NpzFile:
    """A file of ``numpy.savez`` or ``scipy.sparse.save_npz``.

    A sparse matrix is ``<name>_data``, ``<name>_indices``, ``<name>_indptr``, ``<name>_shape`` and
    ``<name>_format``, ``csr`` where that is not there. That of ``save_npz`` has no name.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    @cached_property
    def _arrays(self) -> dict[str, tuple[tuple[int, ...], np.dtype]]:
        """Shape and type of all arrays."""
        arrays = {}
        with ZipFile(self._path) as archive:
            for member in archive.infolist():
                if not member.filename.endswith(_SUFFIX):
                    continue
                with archive.open(member) as file:
                    version = np.lib.format.read_magic(file)
                    if version not in _HEADERS:
                        raise UnsuitableVariable(f"has arrays of version {version}")
                    shape, _, dtype = _HEADERS[version](file)
                name = member.filename.removesuffix(_SUFFIX)
                if dtype.kind != "O" and prod(shape) * dtype.itemsize > member.file_size:
                    raise UnsuitableVariable(f"holds fewer numbers of {name} than it declares")
                arrays[name] = shape, dtype
        return arrays

    def names(self) -> list[str]:
        if "format" in self._arrays and "shape" in self._arrays:
            return []
        heads = [name.removesuffix("_shape") for name in self._arrays if name.endswith("_shape")]
        matrices = [head for head in heads if f"{head}_data" in self._arrays]
        parts = ("data", "indices", "indptr", "shape", "format", "row", "col")
        within = {f"{head}_{part}" for head in matrices for part in parts}
        return sorted({*matrices, *(set(self._arrays) - within)})

    def size(self, name: str) -> Size:
        if name in self._arrays:
            shape, dtype = self._arrays[name]
            require_numbers(dtype)
            return dense_size(shape)
        head = self._head(name)
        return Size(self._shape(head), prod(self._arrays[f"{head}data"][0]), is_sparse=True)

    def read(self, name: str) -> NDArray | sparse.sparray:
        if name in self._arrays:
            require_numbers(self._arrays[name][1])
            return self._array(name)
        head = self._head(name)
        kind, shape = self._format(head), self._shape(head)
        parts = _PARTS[kind]
        for part in parts:
            if f"{head}{part}" not in self._arrays:
                raise UnsuitableVariable(f"is no sparse matrix: {head}{part} is not there")
        values, one, other = (self._array(f"{head}{part}") for part in parts)
        if kind != "coo":
            return columns_or_rows(values, one, other, shape, kind)
        require_numbers(values.dtype)
        try:
            return sparse.coo_array((values, (one, other)), shape=shape).tocsc()
        except (ValueError, TypeError) as error:
            raise UnsuitableVariable(f"is no sparse matrix: {error}") from error

    def _head(self, name: str) -> str:
        """What stands before the names of the parts of a sparse matrix."""
        return f"{name}_" if f"{name}_shape" in self._arrays else ""

    def _shape(self, head: str) -> tuple[int, ...]:
        shape, dtype = self._arrays[f"{head}shape"]
        if shape != (2,) or dtype.kind not in "iu" or f"{head}data" not in self._arrays:
            raise UnsuitableVariable("is no sparse matrix: its shape is not that of a matrix")
        rows, columns = self._array(f"{head}shape").tolist()
        return rows, columns

    def _format(self, head: str) -> str:
        if f"{head}format" not in self._arrays:
            return "csr"
        shape, dtype = self._arrays[f"{head}format"]
        kind = self._array(f"{head}format").item() if not shape and dtype.kind in "SU" else ""
        kind = kind.decode(errors="replace") if isinstance(kind, bytes) else kind
        if kind not in _PARTS:
            sentence = f"is a sparse matrix of format {kind!r}: allowed: csr, csc, coo"
            raise UnsuitableVariable(sentence)
        return kind

    def _array(self, name: str) -> NDArray:
        with ZipFile(self._path) as archive, archive.open(f"{name}{_SUFFIX}") as file:
            array = np.lib.format.read_array(file, allow_pickle=False)
            # the end of the file, where its checksum is compared
            file.read(1)
        return array
