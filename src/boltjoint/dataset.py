"""Results as netCDF files, with units on every variable and a checksum of their content.

The checksum is at the end of the file (``checksums``), where other programs do not see it. It is
compared before HDF5 opens the file, so that a result that was damaged after it was written is never
used.
"""

from collections.abc import Iterable, Mapping
from math import prod
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr

from boltjoint import __version__, checks, checksums
from boltjoint.checksums import DamagedFile

#: the parameter of every rule that tells which code runs, not what it computes with
_CODE = "library"
#: largest ratio of compression by zlib
_MOST_COMPRESSED = 1032
#: bytes of a word in a file, which tell where its letters are
_WORD = 16
#: the conventions of climate and forecast data, by which other programs read netCDF files
CONVENTIONS = "CF-1.11"
#: titles of the files of a study, by their names
TITLES = {
    "assembly": "mesh, contact pairs and interfaces of a bolted assembly",
    "structure": "matrices and contact points of a bolted assembly",
    "modes": "modes of the parts of a bolted assembly without contact",
    "pod_modes": "POD modes of the contact of a bolted assembly",
    "patterns": "patterns of contact stiffness of a bolted assembly",
    "preload": "normal load and gaps of the contact under the preload of the bolts",
    "joint": "joint: modes at its contact points, and its friction elements",
    "response": "frequency response of a joint by force levels",
    "backbone": "backbone of a joint: frequency and damping of a mode over its amplitude",
    "calibration": "joint fitted to its measurement",
    "prediction": "measured backbones predicted by a joint that was fitted to others",
    "designs": "designs of a sweep",
    "checked": "designs of a sweep in a larger model",
    "sweep": "peaks and responses of the designs of a sweep",
}
_OTHER_TITLE = "results of a study of bolted joints"
#: further name of the attribute ``coordinates``: CF and xarray have another use for that word
_SECOND_NAMES = {"coordinates": "solution_coordinates"}


def save(
    dataset: xr.Dataset, path: str | Path, parameters: Mapping[str, object] | None = None
) -> None:
    """Write a dataset to netCDF, the same bytes for the same content.

    The file has the attributes that the CF conventions ask for: ``Conventions``, ``title`` and
    ``history``, without a date. What ``coordinates`` says, ``solution_coordinates`` says as well.

    Parameters
    ----------
    dataset
        Every variable must carry a ``units`` attribute (``"1"`` for a pure number).
    path
        The file to write; its folder is made.
    parameters
        What the content was computed with; kept as an attribute beside the library's version.
        ``library``, the hash of the code, is left out: code that computes the same writes the same.

    Raises
    ------
    ValueError
        Naming the variables that have no units.
    """
    checks.instance("dataset", dataset, xr.Dataset)
    path = checks.path("path", path)
    if parameters is None:
        parameters = {}
    if hasattr(parameters, "items"):
        # those of a job of Snakemake are no Mapping
        parameters = dict(parameters.items())
    checks.mapping("parameters", parameters)
    without = [str(name) for name, variable in dataset.variables.items() if not _has_unit(variable)]
    if without:
        raise ValueError(f"no units on {', '.join(without)} (pure numbers have units '1')")
    path.parent.mkdir(parents=True, exist_ok=True)
    made_with = ", ".join(
        f"{name}={value!r}" for name, value in parameters.items() if name != _CODE
    )
    again = {new: dataset.attrs[old] for old, new in _SECOND_NAMES.items() if old in dataset.attrs}
    dataset.assign_attrs(
        again,
        boltjoint_version=__version__,
        parameters=made_with,
        Conventions=CONVENTIONS,
        title=TITLES.get(path.stem) or dataset.attrs.get("title", _OTHER_TITLE),
        history=_history(dataset),
    ).to_netcdf(path, engine="netcdf4")
    checksums.append(path)


def load(path: str | Path) -> xr.Dataset:
    """Read a whole netCDF file into memory and close it.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    DamagedFile
        If the file is not what ``save`` wrote, cannot be read, or declares more values than it can
        hold.
    """
    path = checks.path("path", path)
    size = checksums.verify_appended(path)
    try:
        with netCDF4.Dataset(path) as file:
            declared = sum(map(_least_size, file.variables.values()))
        if declared > size:
            raise DamagedFile(path, f"declares more values than {size} bytes can hold")
        # decoding coordinates would swallow the attribute of that name, which says how a response
        # was solved; coordinates along dimensions are found without it
        return xr.load_dataset(path, engine="netcdf4", decode_coords=False)
    except DamagedFile:
        raise
    except (OSError, RuntimeError, ValueError, TypeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DamagedFile(path, f"cannot be read ({reason})") from error


def quantity(dims: str | tuple[str, ...], values: object, units: str, meaning: str) -> xr.Variable:
    """A variable with its units and one line on what it is."""
    return xr.Variable(dims, values, {"units": units, "long_name": meaning})


Quantity = tuple[str, str | tuple[str, ...], object, str, str]
"""Name of a variable of a dataset, and what ``quantity`` is made of."""


def quantities(rows: Iterable[Quantity]) -> dict[str, xr.Variable]:
    """Variables with their physical units and meanings, by their names."""
    return {
        name: quantity(dims, values, units, meaning) for name, dims, values, units, meaning in rows
    }


def _history(dataset: xr.Dataset) -> str:
    """What wrote a file, one program a line: the last is this one."""
    before = str(dataset.attrs.get("history", "")).splitlines()
    last = f"boltjoint {__version__}"
    return "\n".join(before if before[-1:] == [last] else [*before, last])


def _has_unit(variable: xr.Variable) -> bool:
    # labels (mode names, components) are words, which have no unit
    return variable.dtype.kind in "UOST" or bool(variable.attrs.get("units"))


def _least_size(variable: netCDF4.Variable) -> float:
    """Fewest bytes of a file that can hold the values of a variable."""
    item = variable.dtype.itemsize if isinstance(variable.dtype, np.dtype) else _WORD
    filters = variable.filters() or {}
    is_compressed = any(filters.get(name) for name in ("zlib", "szip", "zstd", "bzip2", "blosc"))
    size = prod(map(int, variable.shape)) * item
    return size / _MOST_COMPRESSED if is_compressed else size
