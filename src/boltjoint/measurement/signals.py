"""Measured signals: motion of sensors at equally spaced times, in SI units."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

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
