"""How results are kept: netCDF files whose every variable has units."""

from collections.abc import Mapping
from pathlib import Path

import xarray as xr

from boltjoint import __version__


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

    Raises
    ------
    ValueError
        Naming the variables that have no units.
    """
    without = [str(name) for name, variable in dataset.variables.items() if not _has_unit(variable)]
    if without:
        raise ValueError(f"no units on {', '.join(without)} (pure numbers have units '1')")
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    made_with = ", ".join(f"{name}={value!r}" for name, value in (parameters or {}).items())
    dataset.assign_attrs(boltjoint_version=__version__, parameters=made_with).to_netcdf(
        path, engine="netcdf4"
    )


def load(path: str | Path) -> xr.Dataset:
    """Read a whole netCDF file into memory and close it."""
    # decoding coordinates would swallow the attribute of that name, which says how a response was
    # solved; coordinates along dimensions are found without it
    return xr.load_dataset(path, engine="netcdf4", decode_coords=False)


def quantity(dims: str | tuple[str, ...], values: object, units: str, meaning: str) -> xr.Variable:
    """A variable with its units and one line on what it is."""
    return xr.Variable(dims, values, {"units": units, "long_name": meaning})


def _has_unit(variable: xr.Variable) -> bool:
    # labels (mode names, components) are words, which have no unit
    return variable.dtype.kind in "UOST" or bool(variable.attrs.get("units"))
