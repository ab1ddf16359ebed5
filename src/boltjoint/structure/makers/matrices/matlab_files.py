"""Variables of MATLAB's ``.mat`` files: version 5, and version 7.3, which is HDF5."""

from pathlib import Path

import netCDF4
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.structure.makers.matrices.mat5 import Mat5File
from boltjoint.structure.makers.matrices.variables import (
    Size,
    UnsuitableVariable,
    VariableFile,
    columns_or_rows,
    dense_size,
    require_numbers,
)

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
