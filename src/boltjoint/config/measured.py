"""Measured backbones of a case, and the parameters that are fitted to them."""

from typing import Annotated, Literal

from pydantic import Field

from boltjoint.config.entries import Entry
from boltjoint.config.types import (
    INTEGRAL,
    DataFile,
    Joint,
    ModalBasis,
    ModesCount,
    Name,
    Number,
    Positive,
    Problems,
)

#: the parameter by which measured amplitudes are multiplied
AMPLITUDE_SCALE = "amplitude_scale"

#: losses of ``scipy.optimize.least_squares``
Loss = Literal["linear", "soft_l1", "huber", "cauchy", "arctan"]

_Percent = Annotated[Positive, Field(le=100)]


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
    rows: dict[str, Number] = Field({})
    """Values of other columns, by their names, of the rows that belong to this curve; all rows by
    default."""
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


class FittedParameter(Entry):
    """Bounds of a parameter, and where its fit begins."""

    low: Number
    """Lower bound."""
    high: Number
    """Upper bound."""
    start: Number | None = None
    """Where the first fit begins; by default the value of the case, if the bounds hold it. Other
    fits begin elsewhere within the bounds."""
    log: Annotated[bool, Field(strict=True)] = True
    """Whether steps and errors are of its logarithm."""

    def conflicts(self) -> Problems:
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
    basis: ModalBasis | None = None
    """A basis of the case; the first of its ``modes`` by default."""
    joint: Annotated[Joint, Field(validate_default=True)] = "node-to-node"
    """A joint that ``solve`` has in this basis."""
    starts: Annotated[int, Field(strict=True, ge=1, le=1000), INTEGRAL] = 8
    """Number of fits from different starts, of which the best is kept: a fit may have several
    minima."""
    seed: Annotated[int, Field(strict=True, ge=0), INTEGRAL] = 1
    """Seed of the starts: with the same one they are the same."""
    loss: Loss = "linear"
    """``linear``, least squares, or a robust loss that counts outliers less."""

    def conflicts(self) -> Problems:
        names = [curve.label for curve in self.curves]
        for index, name in enumerate(names):
            if name in names[:index]:
                yield ("curves", index, "name"), f"must not be {name}, as of a curve before it"
        for key in self.parameters:
            if key.startswith(f"{AMPLITUDE_SCALE}["):
                name = key.removeprefix(f"{AMPLITUDE_SCALE}[").removesuffix("]")
                if name not in names:
                    yield ("parameters", key), f"is of no curve; there are: {', '.join(names)}"
