"""Scatter of frequency and damping between sensors, repeats and methods of identification."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.measurement.identification import IdentifiedMode

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scatter:
    """Mean of several identifications of one decay, and their scatter.

    Parameters
    ----------
    time
        Time of the decay [s], shape (points,).
    frequency, frequency_scatter
        Weighted mean, and standard deviation between them [Hz], shape (points,).
    damping_ratio, damping_scatter
        The same [-], shape (points,).
    frequency_over_error, damping_over_error
        Median over the times of the scatter over the stated standard errors: near 1 where these
        hold all of it.
    """

    time: Array
    frequency: Array
    frequency_scatter: Array
    damping_ratio: Array
    damping_scatter: Array
    frequency_over_error: float
    damping_over_error: float


def scatter_between(modes: Sequence[IdentifiedMode]) -> Scatter:
    """Scatter between identifications of one decay, by sensors or methods.

    They are compared at the times of the first that lie within all.

    Parameters
    ----------
    modes
        Two or more, of one decay.

    Raises
    ------
    ValueError
        If there are fewer, or they have no time in common.
    """
    checks.sequence("modes", modes, IdentifiedMode)
    if len(modes) < 2:
        raise ValueError(f"modes has {len(modes)}: scatter is between two at least")
    begin, end = max(m.time.min() for m in modes), min(m.time.max() for m in modes)
    time = modes[0].time[(modes[0].time >= begin) & (modes[0].time <= end)]
    if time.size == 0:
        raise ValueError("modes have no time in common")

    def at_times(name: str) -> Array:
        return np.array([np.interp(time, m.time, getattr(m, name)) for m in modes])

    of_frequency = _mean(at_times("frequency"), at_times("frequency_error"))
    of_damping = _mean(at_times("damping_ratio"), at_times("damping_error"))
    return Scatter(time, *of_frequency[:2], *of_damping[:2], of_frequency[2], of_damping[2])


def _mean(values: Array, errors: Array) -> tuple[Array, Array, float]:
    """Weighted mean, scatter, and the median of the scatter over what the errors explain."""
    weight = 1 / errors**2
    mean = (weight * values).sum(axis=0) / weight.sum(axis=0)
    scatter = values.std(axis=0, ddof=1)
    chi = (weight * (values - mean) ** 2).sum(axis=0) / (len(values) - 1)
    return mean, scatter, float(np.sqrt(np.median(chi)))
