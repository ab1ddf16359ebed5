"""The input files of a stage of the workflow, by what they hold."""

import json
from collections.abc import Iterable
from functools import cache, partial
from typing import Any

import pandas as pd
import xarray as xr

from boltjoint import checksums, csv_files, dataset
from boltjoint.study import layout


class Results:
    """Files of a study, each read once.

    Parameters
    ----------
    paths
        The files that may be read; another one is a ``LookupError``.
    """

    def __init__(self, paths: Iterable[str]) -> None:
        self._paths = frozenset(map(str, paths))
        self._load = cache(dataset.load)
        # as text: tables 3.1 and 3.10 are two
        self._read = cache(partial(csv_files.read, dtype={"source_table": str}))

    def dataset(self, kind: str, **fields: object) -> xr.Dataset:
        """A netCDF file (``layout.path``)."""
        return self._load(self._permitted(layout.path(kind, **fields)))

    def data(self, kind: str, **fields: object) -> pd.DataFrame:
        """A CSV file of data (``layout.path``)."""
        return self._read(self._permitted(layout.path(kind, **fields)))

    def record(self, kind: str, **fields: object) -> dict[str, Any]:
        """A JSON file (``layout.path``)."""
        path = self._permitted(layout.path(kind, **fields))
        try:
            record = json.loads(checksums.read_text(path))
        except json.JSONDecodeError as error:
            raise checksums.DamagedFile(path, f"cannot be read ({error})") from error
        if not isinstance(record, dict):
            raise checksums.DamagedFile(path, "cannot be read (it holds no keys with values)")
        return record

    def table(self, kind: str, **fields: object) -> pd.DataFrame:
        """A table (``layout.shown``)."""
        return self._read(self._permitted(layout.shown("table", kind, **fields)))

    def has(self, kind: str, **fields: object) -> bool:
        """Whether a file of data is among those that may be read."""
        return layout.path(kind, **fields) in self._paths

    def _permitted(self, path: str) -> str:
        if path not in self._paths:
            raise LookupError(f"{path} is not an input of this stage")
        return path
