"""Measured backbones as a calibration takes them: curves with their standard deviations."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.calibration.measured_response import MeasuredResponse, require_configuration
from boltjoint.config.measured_tables import MODAL
from boltjoint.measurement.identification import IdentifiedMode
from boltjoint.measurement.signals import MOTIONS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeasuredBackbone:
    """Frequency and damping of a mode over its amplitude, with standard deviations.

    Parameters
    ----------
    amplitude
        Of the sensor [SI unit of its quantity] or of the mode [kg^1/2 m], shape (points,).
    frequency, frequency_deviation
        Natural frequency and its standard deviation [Hz], shape (points,); one number is that of
        all points.
    damping_ratio, damping_deviation
        Damping ratio and its standard deviation [-], in the same way.
    quantity
        ``displacement``, ``velocity``, ``acceleration`` or ``modal``.
    resonance
        Number of the mode in the model, from 1; by default that of the shape, or of the nearest
        frequency.
    sensor
        Name of the output of the model; by default its output point.
    name
        Of the curve, in messages and results.
    shape
        Amplitudes of two or more sensors in the mode, by the names of outputs of the model, with
        signs: the mode of the model is that of the largest modal assurance criterion (MAC).
    configuration
        Values of the model in which it was measured, by their names, as ``preload_N``: they take
        the place of fitted ones.

    Raises
    ------
    ValueError
        If shapes differ or a value is out of range.
    """

    amplitude: Array
    frequency: Array
    frequency_deviation: Array | float
    damping_ratio: Array
    damping_deviation: Array | float
    quantity: str = "displacement"
    resonance: int | None = None
    sensor: str | None = None
    name: str = "mode"
    shape: Mapping[str, float] | None = None
    configuration: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what is no curve, and sort it by the amplitude."""
        checks.instance("name", self.name, str)
        checks.choice("quantity", self.quantity, (*MOTIONS, MODAL))
        if self.resonance is not None:
            checks.whole("resonance", self.resonance, at_least=1)
        if self.sensor is not None:
            checks.instance("sensor", self.sensor, str)
        if self.shape is not None:
            self._require_shape(self.shape)
        require_configuration(self.configuration)
        amplitude = checks.array("amplitude", self.amplitude, ("points",), above=0)
        if amplitude.size == 0:
            raise ValueError(f"amplitude of {self.name} is empty: a curve has a point at least")
        order = np.argsort(amplitude, kind="stable")
        object.__setattr__(self, "amplitude", amplitude[order])
        positive, share = checks.Limits(above=0), checks.Limits(above=0, below=1)
        for name, limits in (
            ("frequency", positive),
            ("frequency_deviation", positive),
            ("damping_ratio", share),
            ("damping_deviation", positive),
        ):
            check = checks.of_each if name.endswith("deviation") else checks.array
            value = check(name, getattr(self, name), amplitude.shape, **limits)
            object.__setattr__(self, name, value[order])

    def _require_shape(self, shape: Mapping[str, float]) -> None:
        """Refuse a shape that tells no mode."""
        if self.resonance is not None:
            raise ValueError(f"{self.name} has a shape and a resonance: one of them tells its mode")
        checks.mapping("shape", shape)
        for sensor, value in shape.items():
            checks.number(f"shape of {self.name} at {sensor}", value)
        if np.count_nonzero(list(shape.values())) < 2:
            raise ValueError(
                f"shape of {self.name} has {len(shape)} sensors: two that move are needed"
            )

    @property
    def points(self) -> int:
        """Number of points."""
        return len(self.frequency)

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of outputs that the model must have."""
        own = () if self.sensor is None else (self.sensor,)
        return (*own, *(self.shape or ()))

    @property
    def quantities(self) -> tuple[str, ...]:
        """What is compared."""
        return "frequency", "damping"

    @property
    def values(self) -> Array:
        """Frequency [Hz] and damping ratio, shape (points, 2)."""
        return np.column_stack([self.frequency, self.damping_ratio])

    @property
    def deviations(self) -> Array:
        """Standard deviations of the values, shape (points, 2)."""
        return np.column_stack([self.frequency_deviation, self.damping_deviation])

    def difference(self, model: Array) -> Array:
        """Values of a model less those measured, (points, 2)."""
        return model - self.values

    def rms_errors(self, model: Array) -> tuple[float, float]:
        """Root mean square of the relative errors of frequency and damping of a model.

        Parameters
        ----------
        model
            Frequency [Hz] and damping ratio at the amplitudes, shape (points, 2).
        """
        f, z = np.sqrt(np.mean((model / self.values - 1) ** 2, axis=0))
        return float(f), float(z)

    @classmethod
    def of(
        cls,
        mode: IdentifiedMode,
        *,
        resonance: int | None = None,
        sensor: str | None = None,
        name: str = "mode",
    ) -> "MeasuredBackbone":
        """The curve of an identified mode, with its standard errors.

        Parameters
        ----------
        mode
            As ``identify_ring_down`` returns it.
        resonance, name
            As for the class.
        sensor
            Name of the output of the model that was measured. By default that of the mode; where
            the file tells none, as a column ``acceleration_m_per_s2``, the output point.
        """
        checks.instance("mode", mode, IdentifiedMode)
        # a signal without a name has that of its quantity
        if sensor is None and mode.sensor != mode.quantity:
            sensor = mode.sensor
        return cls(
            mode.amplitude,
            mode.frequency,
            mode.frequency_error,
            mode.damping_ratio,
            mode.damping_error,
            quantity=mode.quantity,
            resonance=resonance,
            sensor=sensor,
            name=name,
        )


#: what a fit compares with a model
Measurement = MeasuredBackbone | MeasuredResponse


def curves_of(measured: Sequence[Measurement] | Measurement) -> tuple[Measurement, ...]:
    """One or several curves as a tuple.

    Raises
    ------
    ValueError
        If there is none, or one is of another kind.
    """
    kinds = MeasuredBackbone, MeasuredResponse
    curves = (measured,) if isinstance(measured, kinds) else measured
    checks.sequence("measured", curves, *kinds)
    if not curves:
        raise ValueError("measured is empty: there must be one curve at least")
    return tuple(curves)
