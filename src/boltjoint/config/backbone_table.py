"""Tables of measured backbones: frequency and damping ratio over amplitude, from a CSV file."""

from collections.abc import Mapping
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


def read_backbone_table(text: str, file: str, rows: Mapping[str, float]) -> BackboneTable:
    """The points of a backbone in the text of a CSV file.

    Parameters
    ----------
    text, file
        What the file holds, and its name.
    rows
        Values of other columns in the rows that belong to it.

    Raises
    ------
    TableError
        If a column is missing or not clear, no row has the values, or a value is out of range.
    ValueError
        If an argument is of another kind.
    """
    checks.mapping("rows", rows)
    rows = {str(key): checks.number(f"{key} of rows", value) for key, value in rows.items()}
    table = CsvTable(text, file)
    keys = table.keys
    if again := [key for index, key in enumerate(keys) if key in keys[:index]]:
        raise TableError(f"{file}:1: {again[0]}: must not appear twice")
    columns = table.columns()
    amplitude = _column_of_amplitude(keys, file)
    for key in (_FREQUENCY, _DAMPING):
        if key not in columns:
            raise TableError(f"{file}:1: there must be a column {key}")
    for key in rows:
        if key not in columns:
            raise TableError(f"{file}:1: has no column {key}; there are: {', '.join(keys)}")
    chosen = np.ones(columns[amplitude].size, bool)
    for key, value in rows.items():
        chosen &= columns[key] == value
    if not chosen.any():
        told = " and ".join(f"{key} {value:g}" for key, value in rows.items())
        raise TableError(f"{file}: has no row{' with ' if told else ''}{told}")
    if (count := int(chosen.sum())) > MOST_POINTS:
        raise TableError(f"{file}: has {count} points: must have at most {MOST_POINTS}")
    for key in (amplitude, _FREQUENCY, _DAMPING, _FREQUENCY_STD, _DAMPING_STD):
        if key in columns:
            _require_range(columns[key], chosen, key, file)
    quantity, factor = AMPLITUDES[amplitude]
    of_curve = {key: values[chosen] for key, values in columns.items()}
    return BackboneTable(
        of_curve[amplitude] * (1.0 if factor is None else factor),
        quantity,
        factor is not None,
        of_curve[_FREQUENCY],
        of_curve[_DAMPING],
        of_curve.get(_FREQUENCY_STD),
        of_curve.get(_DAMPING_STD),
    )


def _column_of_amplitude(keys: list[str], file: str) -> str:
    """The one column that holds amplitudes."""
    given = [key for key in keys if key in AMPLITUDES]
    if len(given) == 1:
        return given[0]
    if given:
        raise TableError(f"{file}:1: {' and '.join(given)}: must be one column of amplitudes")
    raise TableError(
        f"{file}:1: there must be a column of amplitudes: {', '.join(AMPLITUDES)}; those without "
        "a unit need the parameter amplitude_scale"
    )


def _require_range(values: Array, chosen: NDArray[np.bool_], key: str, file: str) -> None:
    """Refuse values that are not positive, and ratios of 1 and above."""
    wrong = chosen & ~(values > 0)
    sentence = "must be greater than 0"
    if key == _DAMPING and not wrong.any():
        wrong, sentence = chosen & (values >= 1), "must be less than 1: it is a ratio, not percent"
    if wrong.any():
        at = int(np.argmax(wrong))
        raise TableError(f"{file}:{at + 2}: {key}: {values[at]:g} {sentence}")
