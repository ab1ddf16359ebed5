"""The input files of a stage of the workflow, by what they hold."""

from collections.abc import Iterable
from functools import cache

import pandas as pd
import xarray as xr

from boltjoint import dataset
from boltjoint.study import layout
from boltjoint.study.tables import files as tables


class Results:
    """Files of a study, each read once.

    Parameters
    ----------
    paths
        The files that may be read; another one is a ``LookupError``.
    """

    def __init__(self, paths: Iterable[str]) -> None:
        self._paths = frozenset(map(str, paths))
        self._load, self._read = cache(dataset.load), cache(tables.read)

    def dataset(self, kind: str, **which: object) -> xr.Dataset:
        """A netCDF file (``layout.path``)."""
        return self._load(self._permitted(layout.path(kind, **which)))

    def data(self, kind: str, **which: object) -> pd.DataFrame:
        """A CSV file of data (``layout.path``)."""
        return self._read(self._permitted(layout.path(kind, **which)))

    def table(self, kind: str, **which: object) -> pd.DataFrame:
        """A table (``layout.shown``)."""
        return self._read(self._permitted(layout.shown("table", kind, **which)))

    def has(self, kind: str, **which: object) -> bool:
        """Whether a file of data is among those that may be read."""
        return layout.path(kind, **which) in self._paths

    def _permitted(self, path: str) -> str:
        if path not in self._paths:
            raise LookupError(f"{path} is not an input of this stage")
        return path
