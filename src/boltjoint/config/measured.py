"""Measured backbones of a case: their tables, and the parameters that are fitted to them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Discriminator, Field, Tag

from boltjoint import checks
from boltjoint.config.csv_table import CsvTable, TableError
from boltjoint.config.entries import Entry, EntryWithLaterKeys
from boltjoint.config.types import (
    INTEGRAL,
    DataFile,
    Joint,
    ModalBasis,
    ModesCount,
    Name,
    Number,
    NumberOfKey,
    Positive,
    PositiveOfKey,
    Problems,
)
from boltjoint.config.units import MOTION_UNITS

#: the parameter by which measured amplitudes are multiplied
AMPLITUDE_SCALE = "amplitude_scale"

#: losses of ``scipy.optimize.least_squares``
Loss = Literal["linear", "soft_l1", "huber", "cauchy", "arctan"]

_Percent = Annotated[Positive, Field(le=100)]
_Cell = Annotated[
    Annotated[Number, Tag("number")]
    | Annotated[str, Field(min_length=1, max_length=100), Tag("word")],
    Discriminator(
        lambda value: (
            "word" if isinstance(value, str) else "number" if type(value) in (int, float) else None
        ),
        custom_error_type="no_values",
        custom_error_message="must be a number or a word",
    ),
]


class MeasuredCurve(Entry):
    """Frequency and damping ratio of one mode over its amplitude, from a CSV file."""

    file: DataFile
    """The table, seen from the folder of ``config/``: columns ``frequency_Hz``, ``damping_ratio``
    and the amplitude, whose name tells quantity and unit as ``acceleration_m_per_s2``, see
    [docs/measurement.md](../docs/measurement.md). Standard deviations in ``frequency_std_Hz`` and
    ``damping_ratio_std``, if there are any."""
    resonance: ModesCount
    """Number of the mode in the model, as of a block of ``solve``."""
    name: Name | None = None
    """Name of the curve; ``mode-N`` by default, with the number of the resonance."""
    rows: dict[str, _Cell] = Field({})
    """Values of other columns, by their names, of the rows that belong to this curve: numbers, or
    words as ``sensor: acc1``. All rows by default."""
    sensor: Name | None = None
    """Sensor or output of the case that was measured; by default its output point."""
    frequency_error_percent: _Percent | None = None
    """Standard deviation of the frequency beside that of the file, as of temperature or from one
    assembly to the next. Required where the file has none. What a model leaves out counts as well:
    residuals are compared with it."""
    damping_error_percent: _Percent | None = None
    """The same of the damping ratio."""

    @property
    def label(self) -> str:
        """Its name."""
        return self.name or f"mode-{self.resonance}"


class KnownBefore(Entry):
    """What is known of a parameter before it is fitted: a normal distribution."""

    mean: NumberOfKey
    """Its mean, within the bounds; the median with ``log: true``."""
    standard_deviation: PositiveOfKey
    """Its standard deviation; with ``log: true`` that of the natural logarithm: 0.2 is 20 %."""


class FittedParameter(EntryWithLaterKeys):
    """Bounds of a parameter, what is known of it, and where its fit begins."""

    LATER_KEYS = frozenset({"prior"})

    low: NumberOfKey
    """Lower bound."""
    high: NumberOfKey
    """Upper bound."""
    start: NumberOfKey | None = None
    """Where the first fit begins; by default the value of the case, if the bounds hold it. Other
    fits begin elsewhere within the bounds."""
    log: Annotated[bool, Field(strict=True)] = True
    """Whether steps and errors are of its logarithm."""
    prior: KnownBefore | None = None
    """What is known of it beforehand, as the scatter of a preload by torque. By default only the
    bounds are."""

    def conflicts(self) -> Problems:
        if self.prior is not None and not self.low <= self.prior.mean <= self.high:
            yield ("prior", "mean"), f"must lie between {self.low:g} and {self.high:g}"
        if not self.low < self.high:
            yield ("low",), f"must be less than high, {self.high:g}"
        elif self.log and self.low <= 0:
            yield ("low",), "must be greater than 0 with log: true"
        elif self.start is not None and not self.low <= self.start <= self.high:
            yield ("start",), f"must lie between {self.low:g} and {self.high:g}"


class Measured(Entry):
    """Measured backbones, and the parameters that are fitted to them.

    The joint is reduced once; each step of the fit rescales it, as designs of a sweep do.
    """

    curves: Annotated[tuple[MeasuredCurve, ...], Field(min_length=1, max_length=100)]
    """Backbones of one or several modes and sensors, all fitted at once."""
    parameters: Annotated[dict[str, FittedParameter], Field(min_length=1, max_length=50)]
    """What is fitted, with bounds: keys of the case that a sweep may vary without another joint, as
    ``contact.friction_coefficient``, ``preload_N`` or ``loss_factor``; ``frequency_ratio``, of all
    natural frequencies without contact to those of the model, as by another Young's modulus;
    ``joint.regions[0].tangential_stiffness`` and ``joint.regions[0].friction_coefficient``, of one
    region to those of the contact; ``amplitude_scale``, or ``amplitude_scale[mode-1]`` of one
    curve, by which measured amplitudes are multiplied."""
    predicted: Annotated[tuple[MeasuredCurve, ...], Field(max_length=100)] = ()
    """Backbones of other modes, sensors or amplitudes that are held aside from the fit: what it
    predicts of them stands beside them, with bands that hold the scatter of the parameters and that
    of the measurement. Of scales of amplitudes only ``amplitude_scale`` is theirs too."""
    basis: ModalBasis | None = None
    """A basis of the case; the first of its ``modes`` by default."""
    joint: Joint = Field("node-to-node", validate_default=True)
    """A joint that ``solve`` has in this basis."""
    starts: Annotated[int, Field(strict=True, ge=1, le=1000), INTEGRAL] = 8
    """Number of fits from different starts, of which the best is kept: a fit may have several
    minima."""
    seed: Annotated[int, Field(strict=True, ge=0), INTEGRAL] = 1
    """Seed of the starts: with the same one they are the same."""
    loss: Loss = "linear"
    """``linear``, least squares, or a robust loss that counts outliers less."""

    def conflicts(self) -> Problems:
        names: list[str] = []
        for key, curve in self.all_curves:
            if curve.label in names:
                yield (*key, "name"), f"must not be {curve.label}, as of a curve before it"
            names.append(curve.label)
        fitted = names[: len(self.curves)]
        for parameter in self.parameters:
            if parameter.startswith(f"{AMPLITUDE_SCALE}["):
                name = parameter.removeprefix(f"{AMPLITUDE_SCALE}[").removesuffix("]")
                if name not in fitted:
                    sentence = f"is of no curve; there are: {', '.join(fitted)}"
                    yield ("parameters", parameter), sentence

    @property
    def all_curves(self) -> tuple[tuple[tuple[str, int], MeasuredCurve], ...]:
        """Those that are fitted, then those that are predicted, with their places among keys."""
        return tuple(
            ((key, index), curve)
            for key in ("curves", "predicted")
            for index, curve in enumerate(getattr(self, key))
        )


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
    checks.mapping("rows", rows)
    rows = {
        str(key): value if isinstance(value, str) else checks.number(f"{key} of rows", value)
        for key, value in rows.items()
    }
    table = CsvTable(text, file)
    keys = table.keys
    if again := [key for index, key in enumerate(keys) if key in keys[:index]]:
        raise TableError(f"{file}:1: {again[0]}: must not appear twice")
    amplitude = _column_of_amplitude(keys, file)
    for key in (_FREQUENCY, _DAMPING):
        if key not in keys:
            raise TableError(f"{file}:1: there must be a column {key}")
    for key in rows:
        if key not in keys:
            raise TableError(f"{file}:1: has no column {key}; there are: {', '.join(keys)}")
    own = (amplitude, _FREQUENCY, _DAMPING, _FREQUENCY_STD, _DAMPING_STD)
    of_curve, lines = table.rows_with(rows, [key for key in own if key in keys], MOST_POINTS)
    for key, values in of_curve.items():
        _require_range(values, lines, key, file)
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


def _column_of_amplitude(keys: list[str], file: str) -> str:
    """The one column that holds amplitudes."""
    amplitudes = [key for key in keys if key in AMPLITUDES]
    if len(amplitudes) == 1:
        return amplitudes[0]
    if amplitudes:
        raise TableError(f"{file}:1: {' and '.join(amplitudes)}: must be one column of amplitudes")
    raise TableError(
        f"{file}:1: there must be a column of amplitudes: {', '.join(AMPLITUDES)}; those without "
        "a unit need the parameter amplitude_scale"
    )


def _require_range(values: Array, lines: list[int], key: str, file: str) -> None:
    """Refuse values that are not positive, and ratios of 1 and above."""
    wrong = ~(values > 0)
    sentence = "must be greater than 0"
    if key == _DAMPING and not wrong.any():
        wrong, sentence = values >= 1, "must be less than 1: it is a ratio, not percent"
    if wrong.any():
        at = int(np.argmax(wrong))
        raise TableError(f"{file}:{lines[at]}: {key}: {values[at]:g} {sentence}")
