"""Measured backbones of a case: their tables, and the parameters that are fitted to them."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

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


class MeasuredTable(EntryWithLaterKeys):
    """A table of measured points, and where and in which configuration they were measured."""

    LATER_KEYS = frozenset({"configuration"})

    file: DataFile
    """The table, seen from the folder of ``config/``. The name of the column of amplitudes tells
    quantity and unit as ``acceleration_m_per_s2``, see
    [docs/measurement.md](../docs/measurement.md)."""
    rows: dict[str, _Cell] = Field({})
    """Values of other columns, by their names, of the rows that belong to this curve: numbers, or
    words as ``sensor: acc1``. All rows by default."""
    sensor: Name | None = None
    """Sensor or output of the case that was measured; by default its output point."""
    configuration: dict[str, NumberOfKey] | None = None
    """Values of keys of the case with which it was measured, as ``preload_N: 5000``: of those that
    may be fitted. They take the place of values of the case, and of fitted ones."""

    @property
    def label(self) -> str:
        """Name of the curve."""
        raise NotImplementedError


class MeasuredCurve(MeasuredTable):
    """Frequency and damping ratio of one mode over its amplitude, from a CSV file.

    Columns are ``frequency_Hz``, ``damping_ratio`` and the amplitude; standard deviations
    ``frequency_std_Hz`` and ``damping_ratio_std``, if there are any.
    """

    LATER_KEYS = frozenset({"configuration", "shape"})

    resonance: ModesCount | None = None
    """Number of the mode in the model, as of a block of ``solve``; by default that of ``shape``, or
    of the nearest frequency."""
    shape: Annotated[dict[Name, Number], Field(min_length=2)] | None = None
    """Amplitudes of sensors in the mode, with signs, by names of sensors of the case: the mode of
    the model is that of the largest modal assurance criterion (MAC)."""
    name: Name | None = None
    """Name of the curve; ``mode-N`` by default, with the number of the resonance."""
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

    def conflicts(self) -> Problems:
        if self.resonance is None and self.name is None:
            yield ("name",), "is missing: a curve without a resonance needs one"
        if self.resonance is not None and self.shape is not None:
            yield ("shape",), "must not stand beside resonance: one of them tells the mode"
        if self.shape is not None and sum(value != 0 for value in self.shape.values()) < 2:
            yield ("shape",), "must have two sensors that move"


class MeasuredSteppedSine(MeasuredTable):
    """Excitation and response of stepped sines, from a CSV file.

    Columns are ``frequency_Hz``, the amplitude, and ``force_N`` or, of supports that move,
    ``base_acceleration_m_per_s2``; ``phase_rad`` or ``phase_deg`` of the response from the
    excitation, if there is one. Level of excitation or of response may be constant, or neither. At
    each frequency and amplitude excitations are compared. Under an acceleration of the supports
    the response is that relative to them, as everywhere here.
    """

    name: Name
    """Name of the curve."""
    excitation_error_percent: _Percent
    """Standard deviation of the excitation, with that of the amplitude and what a model leaves
    out."""
    phase_error_deg: Annotated[Positive, Field(le=90)] | None = None
    """Standard deviation of the phase; without it phases are not compared."""

    @property
    def label(self) -> str:
        """Its name."""
        return self.name


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


class Measured(EntryWithLaterKeys):
    """Measured backbones and responses, and the parameters that are fitted to them.

    The joint is reduced once; each step of the fit rescales it, as designs of a sweep do.
    """

    LATER_KEYS = frozenset({"responses"})

    curves: Annotated[tuple[MeasuredCurve, ...], Field(max_length=100)] = ()
    """Backbones of one or several modes, sensors and configurations, all fitted at once."""
    responses: Annotated[tuple[MeasuredSteppedSine, ...], Field(max_length=100)] | None = None
    """Stepped sines that are fitted at once with the backbones, or without any."""
    parameters: Annotated[dict[str, FittedParameter], Field(min_length=1, max_length=50)]
    """What is fitted, with bounds: keys of the case that a sweep may vary without another joint, as
    ``contact.friction_coefficient``, ``preload_N`` or ``loss_factor``; ``frequency_ratio``, of all
    natural frequencies without contact to those of the model, as by another Young's modulus;
    ``preload_ratios[0]``, the preload of a bolt over ``preload_N``, of a joint ``node-to-node``;
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
    minima. Of preloads of bolts, states with all bolts as in the case or one loose at which fits
    begin, until the model can be right."""
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
        if not self.curves and not self.responses:
            yield ("curves",), "is missing: there must be a curve, or one of responses"
        fitted = [curve.label for _, curve in self.fitted_curves]
        for parameter in self.parameters:
            if parameter.startswith(f"{AMPLITUDE_SCALE}["):
                name = parameter.removeprefix(f"{AMPLITUDE_SCALE}[").removesuffix("]")
                if name not in fitted:
                    sentence = f"is of no curve; there are: {', '.join(fitted)}"
                    yield ("parameters", parameter), sentence

    @property
    def fitted_curves(self) -> tuple[tuple[tuple[str, int], MeasuredTable], ...]:
        """Backbones and responses that are fitted, with their places among keys."""
        return self._with_places("curves", "responses")

    @property
    def predicted_curves(self) -> tuple[tuple[tuple[str, int], MeasuredTable], ...]:
        """Backbones that are held aside, with their places among keys."""
        return self._with_places("predicted")

    @property
    def all_curves(self) -> tuple[tuple[tuple[str, int], MeasuredTable], ...]:
        """Those that are fitted, then those that are predicted, with their places among keys."""
        return (*self.fitted_curves, *self.predicted_curves)

    def _with_places(self, *keys: str) -> tuple[tuple[tuple[str, int], MeasuredTable], ...]:
        return tuple(
            ((key, index), curve)
            for key in keys
            for index, curve in enumerate(getattr(self, key) or ())
        )
