"""Tables of measured joints: backbones, and responses at levels, from the text of CSV files."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.config.csv_table import CsvTable, TableError
from boltjoint.config.units import MOTION_UNITS

Array = NDArray[np.float64]

#: amplitudes of the mode itself, of unit modal mass [kg^1/2 m]
MODAL = "modal"

#: by the name of its column, quantity and factor to SI; None where the unit is not known
AMPLITUDES: dict[str, tuple[str, float | None]] = {
    **{
        f"{quantity}_{unit}": (quantity, factor)
        for quantity, units in MOTION_UNITS.items()
        for unit, factor in units.items()
    },
    "modal_amplitude": (MODAL, 1.0),
    **{f"{quantity}_amplitude": (quantity, None) for quantity in MOTION_UNITS},
}
_FREQUENCY, _DAMPING = "frequency_Hz", "damping_ratio"
_FREQUENCY_STD, _DAMPING_STD = "frequency_std_Hz", "damping_ratio_std"

#: points beyond which a fit takes hours
MOST_POINTS = 10_000


@dataclass(frozen=True)
class BackboneTable:
    """Points of a measured backbone, in SI units.

    Attributes
    ----------
    amplitude
        Shape (points,).
    quantity
        ``displacement``, ``velocity``, ``acceleration`` or ``modal``.
    has_unit
        Whether the file tells its unit; otherwise numbers are as if in SI units.
    frequency, damping_ratio
        In Hz and 1, (points,).
    frequency_std, damping_std
        Standard deviations, (points,); None where the file has none.
    """

    amplitude: Array
    quantity: str
    has_unit: bool
    frequency: Array
    damping_ratio: Array
    frequency_std: Array | None
    damping_std: Array | None

    def deviations(self, frequency_percent: float, damping_percent: float) -> tuple[Array, Array]:
        """Standard deviations of frequency [Hz] and damping ratio: of the file and beside it."""
        pairs = (
            (self.frequency, self.frequency_std, frequency_percent),
            (self.damping_ratio, self.damping_std, damping_percent),
        )
        of_frequency, of_damping = (
            np.hypot(0.0 if std is None else std, percent / 100 * value)
            for value, std, percent in pairs
        )
        return of_frequency, of_damping


def read_backbone_table(text: str, file: str, rows: Mapping[str, float | str]) -> BackboneTable:
    """The points of a backbone in the text of a CSV file.

    Parameters
    ----------
    text, file
        What the file holds, and its name.
    rows
        Numbers or words of other columns in the rows that belong to it.

    Raises
    ------
    TableError
        If a column is missing or not clear, no row has the values, or a value is out of range.
    ValueError
        If an argument is of another kind.
    """
    table = _MeasuredTable(text, file)
    amplitude = table.column_of_amplitude(AMPLITUDES)
    table.require(_FREQUENCY, _DAMPING)
    own = (amplitude, _FREQUENCY, _DAMPING, _FREQUENCY_STD, _DAMPING_STD)
    of_curve = table.numbers(rows, own)
    quantity, factor = AMPLITUDES[amplitude]
    return BackboneTable(
        of_curve[amplitude] * (1.0 if factor is None else factor),
        quantity,
        factor is not None,
        of_curve[_FREQUENCY],
        of_curve[_DAMPING],
        of_curve.get(_FREQUENCY_STD),
        of_curve.get(_DAMPING_STD),
    )


@dataclass(frozen=True)
class ResponseTable:
    """Points of measured responses at levels, in SI units.

    Attributes
    ----------
    frequency
        Of the excitation [Hz], shape (points,).
    amplitude, quantity, has_unit
        As of ``BackboneTable``.
    level, level_unit
        Excitation [N, or m/s2 of the supports] and its unit, (points,).
    phase
        Of the response from the excitation [rad], (points,); None where the file has none.
    """

    frequency: Array
    amplitude: Array
    quantity: str
    has_unit: bool
    level: Array
    level_unit: str
    phase: Array | None


#: columns of the excitation, with its unit
LEVELS = {"force_N": "N", "base_acceleration_m_per_s2": "m/s2"}
#: columns of the phase, with their factors to SI
_PHASES = {"phase_rad": 1.0, "phase_deg": np.pi / 180}


def read_response_table(text: str, file: str, rows: Mapping[str, float | str]) -> ResponseTable:
    """The points of responses in the text of a CSV file.

    Parameters
    ----------
    text, file, rows
        As for ``read_backbone_table``.

    Raises
    ------
    TableError, ValueError
        As for ``read_backbone_table``.
    """
    table = _MeasuredTable(text, file)
    of_motion = {key: value for key, value in AMPLITUDES.items() if value[0] != MODAL}
    amplitude = table.column_of_amplitude(of_motion)
    level = table.one_of(LEVELS, "the excitation")
    if level is None:
        raise TableError(f"{file}:1: there must be a column {' or '.join(LEVELS)}")
    phase = table.one_of(_PHASES, "the phase")
    table.require(_FREQUENCY)
    own = (_FREQUENCY, amplitude, level, *(() if phase is None else (phase,)))
    values = table.numbers(rows, own)
    quantity, factor = AMPLITUDES[amplitude]
    return ResponseTable(
        values[_FREQUENCY],
        values[amplitude] * (1.0 if factor is None else factor),
        quantity,
        factor is not None,
        values[level],
        LEVELS[level],
        None if phase is None else values[phase] * _PHASES[phase],
    )


class _MeasuredTable:
    """The text of a CSV file with named columns, some of which are needed."""

    def __init__(self, text: str, file: str) -> None:
        self._table, self._file = CsvTable(text, file), file
        keys = self._keys = self._table.keys
        if again := [key for index, key in enumerate(keys) if key in keys[:index]]:
            raise TableError(f"{file}:1: {again[0]}: must not appear twice")

    def require(self, *columns: str) -> None:
        """Refuse a table without one of the columns."""
        for key in columns:
            if key not in self._keys:
                raise TableError(f"{self._file}:1: there must be a column {key}")

    def one_of(self, columns: Mapping[str, object], what: str) -> str | None:
        """The one column of several that the table has; None if it has none."""
        own = [key for key in self._keys if key in columns]
        if len(own) > 1:
            raise TableError(f"{self._file}:1: {' and '.join(own)}: must be one column of {what}")
        return own[0] if own else None

    def column_of_amplitude(self, allowed: Mapping[str, object]) -> str:
        """The one column that holds amplitudes."""
        amplitude = self.one_of(allowed, "amplitudes")
        if amplitude is None:
            raise TableError(
                f"{self._file}:1: there must be a column of amplitudes: {', '.join(allowed)}; "
                "those without a unit need the parameter amplitude_scale"
            )
        return amplitude

    def numbers(self, rows: Mapping[str, float | str], columns: Sequence[str]) -> dict[str, Array]:
        """Numbers of those columns that there are, in the rows that belong to a curve."""
        checks.mapping("rows", rows)
        wanted = {
            str(key): value if isinstance(value, str) else checks.number(f"{key} of rows", value)
            for key, value in rows.items()
        }
        for key in wanted:
            if key not in self._keys:
                there = ", ".join(self._keys)
                raise TableError(f"{self._file}:1: has no column {key}; there are: {there}")
        own = [key for key in columns if key in self._keys]
        of_curve, lines = self._table.rows_with(wanted, own, MOST_POINTS)
        for key, values in of_curve.items():
            if key not in _PHASES:
                _require_range(values, lines, key, self._file)
        return of_curve


def _require_range(values: Array, lines: list[int], key: str, file: str) -> None:
    """Refuse values that are not positive, and ratios of 1 and above."""
    wrong = ~(values > 0)
    sentence = "must be greater than 0"
    if key == _DAMPING and not wrong.any():
        wrong, sentence = values >= 1, "must be less than 1: it is a ratio, not percent"
    if wrong.any():
        at = int(np.argmax(wrong))
        raise TableError(f"{file}:{lines[at]}: {key}: {values[at]:g} {sentence}")
