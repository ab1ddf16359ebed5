"""Results as netCDF files, with units on every variable and a checksum of their content.

The checksum is an attribute of the file. It covers names, dimensions, types, attributes and values
as they are stored, so that a result that was damaged after it was written is never used.
"""

from collections.abc import Mapping
from hashlib import blake2b
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr

from boltjoint import __version__

#: the attribute with the hash of all the others and of the variables
CHECKSUM = "checksum"
#: the parameter of every rule that tells which code runs, not what it computes with
_CODE = "library"


class DamagedFile(ValueError):
    """A result that cannot be used, with its file and what to do."""

    def __init__(self, path: str | Path, what: object) -> None:
        super().__init__(f"{path}: {what}: delete it and run again")


def save(
    dataset: xr.Dataset, path: str | Path, parameters: Mapping[str, object] | None = None
) -> None:
    """Write a dataset to netCDF, the same bytes for the same content.

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
    without = [str(name) for name, variable in dataset.variables.items() if not _has_unit(variable)]
    if without:
        raise ValueError(f"no units on {', '.join(without)} (pure numbers have units '1')")
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    given = {name: value for name, value in (parameters or {}).items() if name != _CODE}
    made_with = ", ".join(f"{name}={value!r}" for name, value in given.items())
    dataset.assign_attrs(boltjoint_version=__version__, parameters=made_with).to_netcdf(
        path, engine="netcdf4"
    )
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr(CHECKSUM, _checksum(file))


def load(path: str | Path) -> xr.Dataset:
    """Read a whole netCDF file into memory and close it.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    DamagedFile
        If the file cannot be read, is not what ``save`` wrote, or has no checksum.
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"{path}: there is no such file")
    try:
        with netCDF4.Dataset(path) as file:
            recorded, found = getattr(file, CHECKSUM, None), _checksum(file)
    except (OSError, RuntimeError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DamagedFile(path, f"cannot be read ({reason})") from error
    if recorded is None:
        raise DamagedFile(path, "was written by an older version, without a checksum")
    if recorded != found:
        raise DamagedFile(path, "is damaged, its content does not have its checksum")
    # decoding coordinates would swallow the attribute of that name, which says how a response was
    # solved; coordinates along dimensions are found without it
    dataset = xr.load_dataset(path, engine="netcdf4", decode_coords=False)
    # what is made from this content has a checksum of its own
    del dataset.attrs[CHECKSUM]
    return dataset


def quantity(dims: str | tuple[str, ...], values: object, units: str, meaning: str) -> xr.Variable:
    """A variable with its units and one line on what it is."""
    return xr.Variable(dims, values, {"units": units, "long_name": meaning})


def _has_unit(variable: xr.Variable) -> bool:
    # labels (mode names, components) are words, which have no unit
    return variable.dtype.kind in "UOST" or bool(variable.attrs.get("units"))


def _checksum(file: netCDF4.Dataset) -> str:
    """Hash of everything an open file holds but the checksum itself, whatever the byte order."""
    file.set_auto_maskandscale(False)
    digest = blake2b(digest_size=16)

    def add(*parts: object) -> None:
        for part in parts:
            content = part if isinstance(part, bytes) else repr(part).encode()
            # with the length of each, no byte can move from one part to the next unseen
            digest.update(len(content).to_bytes(8, "little"))
            digest.update(content)

    def add_values(values: object) -> None:
        array = np.asarray(values)
        if array.dtype.kind in "OUS":
            add("words", array.shape, array.astype(str).tolist())
        else:
            little = array.astype(array.dtype.newbyteorder("<"), copy=False)
            add(little.dtype.str, array.shape, little.tobytes())

    def add_attributes(of: netCDF4.Dataset | netCDF4.Variable) -> None:
        for name in sorted(set(of.ncattrs()) - {CHECKSUM}):
            add(name)
            add_values(of.getncattr(name))

    add_attributes(file)
    add(*((name, len(found)) for name, found in sorted(file.dimensions.items())))
    for name, variable in sorted(file.variables.items()):
        add(name, variable.dimensions)
        add_attributes(variable)
        add_values(variable[...])
    return digest.hexdigest()
