"""Signals from CSV tables and from universal files (data set 58)."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np

from boltjoint import checks
from boltjoint.measurement.columns import read_columns
from boltjoint.measurement.signals import UNITS, Signals
from boltjoint.regular_file import require_regular

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
