"""Measured signals: motion of sensors at equally spaced times, from tables and universal files."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.config.csv_table import CsvTable, TableError, read_file
from boltjoint.config.units import MOTION_UNITS
from boltjoint.regular_file import require_regular

Array = NDArray[np.float64]

#: quantities of a sensor, by the derivative of the displacement by time
MOTIONS = {"displacement": 0, "velocity": 1, "acceleration": 2}

#: unit of each quantity in SI
UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s2", "force": "N"}

#: times count as equidistant within this part of a step: those of instruments are rounded
_JITTER = 0.01

#: as many samples in a row at the largest or the smallest value are a clipped signal
_CLIPPED_SAMPLES = 4


@dataclass(frozen=True)
class Signals:
    """Signals of sensors of one quantity at equally spaced times.

    Parameters
    ----------
    time
        Increasing in equal steps [s], shape (samples,).
    values
        In SI units, shape (samples, sensors).
    quantity
        ``displacement``, ``velocity``, ``acceleration`` or ``force``.
    sensors
        Name of each sensor; by default ``sensor 1`` and so on.

    Raises
    ------
    ValueError
        If shapes do not fit, the times are not equidistant, or a signal is at rest or clipped.
    """

    time: Array
    values: Array
    quantity: str
    sensors: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what cannot be a record of free motion."""
        time = checks.array("time", self.time, ("samples",))
        if time.size < 2 or not np.all(np.diff(time) > 0):
            raise ValueError("time must hold two or more values that increase")
        checks.choice("quantity", self.quantity, UNITS)
        values = checks.array("values", self.values, (time.size, "sensors"))
        if values.shape[1] == 0:
            raise ValueError("values has no sensor: it must have a column at least")
        checks.sequence("sensors", self.sensors, str)
        names = tuple(self.sensors) or tuple(f"sensor {n + 1}" for n in range(values.shape[1]))
        if len(names) != values.shape[1] or len(set(names)) < len(names):
            raise ValueError(f"sensors must name each of the {values.shape[1]} signals once")
        for name, value in (("time", time), ("values", values), ("sensors", names)):
            object.__setattr__(self, name, value)
        _require_equal_steps(time)
        for name, signal in zip(names, values.T, strict=True):
            _refuse_clipped(name, signal)

    @property
    def sampling_rate(self) -> float:
        """Samples in a second [Hz]."""
        return (self.time.size - 1) / float(self.time[-1] - self.time[0])

    def of(self, sensors: Sequence[str]) -> "Signals":
        """The signals of some sensors, in their order."""
        checks.sequence("sensors", sensors, str)
        places = [self.sensors.index(checks.choice("sensor", s, self.sensors)) for s in sensors]
        return Signals(self.time, self.values[:, places], self.quantity, tuple(sensors))


def _require_equal_steps(time: Array) -> None:
    steps = np.diff(time)
    mean = steps.mean()
    wrong = np.flatnonzero(abs(steps - mean) > _JITTER * mean)
    if wrong.size:
        at = int(wrong[0])
        raise ValueError(
            f"time is not equidistant: from {time[at]:.9g} s to {time[at + 1]:.9g} s is a step of "
            f"{steps[at]:.4g} s, the mean is {mean:.4g} s"
        )


def _refuse_clipped(name: str, signal: Array) -> None:
    low, high = signal.min(), signal.max()
    if low == high:
        raise ValueError(f"signal of {name} is constant: nothing moves")
    for value in (low, high):
        at_limit = np.concatenate([[0], (signal == value).astype(int), [0]])
        begins, ends = (np.flatnonzero(np.diff(at_limit) == sign) for sign in (1, -1))
        longest = int((ends - begins).max())
        if longest >= _CLIPPED_SAMPLES:
            raise ValueError(
                f"signal of {name} is clipped: {longest} samples in a row are {value:.6g}; "
                "measure again with another range"
            )


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


#: bytes of a universal file
_LARGEST = 500_000_000

#: data set 58: kinds of the ordinate (specific data types) that are motions or forces, and units as
#: its label tells them
_KINDS = {8: "displacement", 11: "velocity", 12: "acceleration", 13: "force"}
_LABELS: dict[str, tuple[str, float]] = {
    **{"m": ("displacement", 1.0), "mm": ("displacement", 1e-3), "um": ("displacement", 1e-6)},
    **{"m/s": ("velocity", 1.0), "mm/s": ("velocity", 1e-3)},
    **{
        "m/s2": ("acceleration", 1.0),
        "m/s^2": ("acceleration", 1.0),
        "m/s**2": ("acceleration", 1.0),
    },
    **{"mm/s2": ("acceleration", 1e-3), "g": ("acceleration", 9.80665)},
    **{"n": ("force", 1.0), "kn": ("force", 1e3), "lbf": ("force", 4.4482216152605)},
}
#: function type of a time response
_TIME_RESPONSE = 1


def read_signals(path: str | PathLike[str], quantity: str | None = None) -> Signals:
    """The signals of one quantity in a file.

    Parameters
    ----------
    path
        ``.csv``: one column ``time_s`` and one for each sensor, as ``acceleration_m_per_s2`` or
        ``tip_velocity_mm_per_s``. ``.uff``, ``.unv`` or ``.ufb``: time responses of data sets 58
        with a unit of the ordinate, which needs pyuff.
    quantity
        ``displacement``, ``velocity``, ``acceleration`` or ``force``; by default the only motion
        that the file has.

    Returns
    -------
    Signals
        Those of the quantity, in SI units.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If units are missing, times are not equidistant, a signal is clipped, or the file has
        another or several quantities.
    """
    path = checks.path("path", path)
    if quantity is not None:
        checks.choice("quantity", quantity, UNITS)
    read = _FORMATS.get(path.suffix.lower())
    if read is None:
        raise ValueError(f"{path} must end as one of {', '.join(_FORMATS)}")
    time, signals = read(path)
    there = sorted({kind for _, kind in signals if kind in UNITS})
    motions = [kind for kind in there if kind != "force"]
    if quantity is None and len(motions) != 1:
        raise ValueError(
            f"{path} has {', '.join(motions) or 'no motion'}: quantity must name one of them"
        )
    quantity = quantity or motions[0]
    own = {name or quantity: value for (name, kind), value in signals.items() if kind == quantity}
    if not own:
        raise ValueError(f"{path} has no {quantity}; there is {', '.join(there)}")
    try:
        return Signals(time, np.column_stack(list(own.values())), quantity, tuple(own))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def _read_csv(path: Path) -> tuple[np.ndarray, dict[tuple[str, str], np.ndarray]]:
    columns = read_columns(str(path), ("time",))
    return columns.pop(("", "time")), columns


def _read_universal(path: Path) -> tuple[np.ndarray, dict[tuple[str, str], np.ndarray]]:
    try:
        import pyuff
    except ImportError:
        raise ValueError(f"{path} needs pyuff: pip install boltjoint[uff]") from None
    require_regular(path, _LARGEST)
    try:
        sets = pyuff.UFF(str(path)).read_sets()
    except Exception as error:  # pyuff raises errors of any kind where a file is damaged
        raise ValueError(f"{path} cannot be read as a universal file: {error}") from None
    sets = [sets] if isinstance(sets, dict) else sets
    records = [
        record
        for record in sets
        if record.get("type") == 58 and record.get("func_type") == _TIME_RESPONSE
    ]
    if not records:
        raise ValueError(f"{path} has no time response in a data set 58")
    time = np.asarray(records[0]["x"], dtype=float)
    signals: dict[tuple[str, str], np.ndarray] = {}
    for number, record in enumerate(records, start=1):
        if not np.array_equal(np.asarray(record["x"], dtype=float), time, equal_nan=True):
            raise ValueError(f"{path}: time response {number} has other times than the first")
        label = str(record.get("ordinate_axis_units_lab", "")).strip()
        kind, factor = _LABELS.get(label.lower(), (None, 1.0))
        expected = _KINDS.get(int(record.get("ordinate_spec_data_type", 0)), kind)
        if kind is None or kind != expected:
            raise ValueError(
                f"{path}: time response {number} has the unit {label or 'none'}: "
                f"it must be one of {', '.join(_LABELS)}, of its quantity"
            )
        name = str(record.get("rsp_ent_name", "")).strip()
        node, direction = int(record.get("rsp_node", 0)), int(record.get("rsp_dir", 0))
        sensor = f"{'' if name in ('', 'NONE') else name + ' '}{node}:{direction:+d}"
        if (sensor, kind) in signals:
            raise ValueError(f"{path}: time response {number} is of sensor {sensor} again")
        signals[sensor, kind] = factor * np.asarray(record["data"]).real
    return time, signals


_FORMATS: dict[str, Callable] = {
    ".csv": _read_csv,
    **dict.fromkeys((".uff", ".unv", ".ufb"), _read_universal),
}
