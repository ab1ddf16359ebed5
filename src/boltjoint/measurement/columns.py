"""Columns of measured tables: names tell sensor, quantity and unit (``tip_velocity_mm_per_s``)."""

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.config.csv_table import CsvTable, TableError, read_file
from boltjoint.config.units import MOTION_UNITS

Array = NDArray[np.float64]

#: units of each quantity, as they end a name, and their factor to SI
_FACTORS = {
    "time": {"s": 1.0, "ms": 1e-3},
    **MOTION_UNITS,
    "force": {"N": 1.0, "kN": 1e3, "lbf": 4.4482216152605},
    "frequency": {"Hz": 1.0},
    "phase": {"rad": 1.0, "deg": np.pi / 180},
}


class Column(NamedTuple):
    """What a column holds: sensor (empty without a name), quantity, and the factor to SI."""

    sensor: str
    quantity: str
    factor: float


def read_columns(path: str, required: tuple[str, ...]) -> dict[tuple[str, str], Array]:
    """All columns of a CSV file in SI units, by sensor and quantity.

    Columns whose names tell no quantity are left out.

    Parameters
    ----------
    path
        The file.
    required
        Quantities of which there must be one column without sensor.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is no table of numbers, a quantity has no unit, or one is missing or there twice.
    """
    table = CsvTable(read_file(path), str(path))
    columns: dict[tuple[str, str], Array] = {}
    values = table.columns()
    if len(values) < len(table.keys):
        raise TableError(f"{path}:1: a name stands twice: each column needs its own")
    for key, value in values.items():
        try:
            column = parse_column(key)
        except ValueError as error:
            raise TableError(f"{path}:1: {error}") from None
        if column is not None:
            place = column.sensor, column.quantity
            if place in columns:
                raise TableError(f"{path}:1: {key}: there is another column of the same")
            columns[place] = column.factor * value
    for quantity in required:
        if ("", quantity) not in columns:
            units = " or ".join(f"{quantity}_{unit}" for unit in _FACTORS[quantity])
            raise TableError(f"{path}:1: there must be a column {units}")
    return columns


def parse_column(key: str) -> Column | None:
    """What a name tells; None where it names no quantity.

    >>> parse_column("tip_velocity_mm_per_s")
    Column(sensor='tip', quantity='velocity', factor=0.001)

    Raises
    ------
    ValueError
        If the quantity has no unit, or none that is known.
    """
    named = re.fullmatch(rf"(?:(.+)_)?({'|'.join(_FACTORS)})(?:_(.+))?", key)
    if named is None:
        return None
    sensor, quantity, unit = named.groups()
    if unit == "std" or (unit or "").startswith("std_"):
        return None
    factors = _FACTORS[quantity]
    if unit not in factors:
        told = f"has the unit {unit}" if unit else "has no unit"
        allowed = ", ".join(f"{quantity}_{allowed_unit}" for allowed_unit in factors)
        raise ValueError(f"{key} {told}: its name must end as {allowed}")
    return Column(sensor or "", quantity, factors[unit])
