"""Measured responses at levels as a calibration takes them: stepped sines with their deviations."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.measurement.signals import MOTIONS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeasuredResponse:
    """Excitation and response of stepped sines, at any levels of either.

    At each measured frequency and amplitude of the sensor the excitation is compared: it has one
    value, where the amplitude under a given excitation has several between folds. Neighbouring
    points should follow each other.

    Parameters
    ----------
    frequency
        Of the excitation [Hz], shape (points,).
    amplitude
        Of the sensor [SI unit of its quantity], (points,), relative to supports that move; one
        number is that of all points, here and below.
    excitation, excitation_deviation
        Level [N, or m/s2 of the supports] and its standard deviation, (points,): that of the
        amplitude and what a model leaves out belong to it.
    phase, phase_deviation
        Of the response from the excitation [rad] and its standard deviation, in the same way; not
        compared by default. A sensor that points the other way is half a turn off.
    quantity
        ``displacement``, ``velocity`` or ``acceleration``.
    sensor
        Name of the output of the model; by default its output point.
    configuration
        Values of the model in which it was measured, by their names, as ``preload_N``: they take
        the place of fitted ones.
    name
        In messages and results.

    Raises
    ------
    ValueError
        If shapes differ, a value is out of range, or a phase has no deviation.
    """

    frequency: Array
    amplitude: Array | float
    excitation: Array | float
    excitation_deviation: Array | float
    phase: Array | float | None = None
    phase_deviation: Array | float | None = None
    quantity: str = "displacement"
    sensor: str | None = None
    configuration: Mapping[str, float] = field(default_factory=dict)
    name: str = "response"

    def __post_init__(self) -> None:
        """Refuse what is no response."""
        checks.instance("name", self.name, str)
        checks.choice("quantity", self.quantity, MOTIONS)
        if self.sensor is not None:
            checks.instance("sensor", self.sensor, str)
        require_configuration(self.configuration)
        frequency = checks.array("frequency", self.frequency, ("points",), above=0)
        if frequency.size == 0:
            raise ValueError(f"frequency of {self.name} is empty: a response has a point at least")
        object.__setattr__(self, "frequency", frequency)
        positive = checks.Limits(above=0)
        names = dict.fromkeys(("amplitude", "excitation", "excitation_deviation"), positive)
        if self.phase is not None:
            if self.phase_deviation is None:
                raise ValueError(f"phase_deviation of {self.name} is missing: phase has one")
            names |= {"phase": checks.Limits(), "phase_deviation": positive}
        for name, limits in names.items():
            value = checks.of_each(name, getattr(self, name), frequency.shape, **limits)
            object.__setattr__(self, name, value)

    @property
    def points(self) -> int:
        """Number of points."""
        return len(self.frequency)

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of outputs that the model must have."""
        return () if self.sensor is None else (self.sensor,)

    @property
    def quantities(self) -> tuple[str, ...]:
        """What is compared."""
        return ("excitation",) if self.phase is None else ("excitation", "phase")

    @property
    def values(self) -> Array:
        """Logarithm of the excitation and, where it is compared, phase, (points, quantities)."""
        columns = [np.log(self.excitation)]
        return np.column_stack(columns if self.phase is None else [*columns, self.phase])

    @property
    def deviations(self) -> Array:
        """Standard deviations of the values, (points, quantities)."""
        columns = [np.asarray(self.excitation_deviation) / self.excitation]
        if self.phase is not None:
            columns.append(np.asarray(self.phase_deviation))
        return np.column_stack(columns)

    def difference(self, model: Array) -> Array:
        """Values of a model less those measured, phases within half a turn."""
        difference = model - self.values
        difference[:, 1:] = np.angle(np.exp(1j * difference[:, 1:]))
        return difference

    def rms_errors(self, model: Array) -> tuple[float, ...]:
        """Root mean square of the relative errors of the excitation, and of those of the phase.

        Parameters
        ----------
        model
            As ``values``.
        """
        difference = self.difference(model)
        difference[:, 0] = np.expm1(difference[:, 0])
        return tuple(np.sqrt(np.mean(difference**2, axis=0)).tolist())


def require_configuration(configuration: Mapping[str, float]) -> None:
    """Refuse what is no mapping of names to numbers."""
    checks.mapping("configuration", configuration)
    for name, value in configuration.items():
        checks.number(f"{name} of configuration", value)
