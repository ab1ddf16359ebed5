"""How much of the limits of its model a structure reaches at peaks (``structure.model_limits``)."""

import logging
from dataclasses import dataclass
from typing import Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.dataset import quantity
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion, motion_at_peak
from boltjoint.structure.model_limits import LIMITS, Limit

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class KnownLimits:
    """The limits of a model that a joint knows.

    Parameters
    ----------
    known
        These limits.
    modes, allowed
        Of each the modes at the places that decide, (place, component, mode), and what is allowed
        at all or each of them.
    """

    known: tuple[Limit, ...] = ()
    modes: tuple[Array, ...] = ()
    allowed: tuple[Array, ...] = ()

    @classmethod
    def of(cls, joint: xr.Dataset) -> Self:
        """Those that ``joint.nc`` has (``structure.model_limits``)."""
        known = tuple(limit for limit in LIMITS if limit.modes in joint)
        modes = (joint[limit.modes].transpose(..., "mode").to_numpy() for limit in known)
        return cls(known, tuple(modes), tuple(joint[limit.limit].to_numpy() for limit in known))

    def reached(self, motion: PeriodicMotion) -> Array:
        """Largest share of each of ``LIMITS`` in the first harmonic of a motion.

        Not a number of those that are not known.
        """
        shares = np.full(len(LIMITS), np.nan)
        sine, cosine = motion.in_components(("sin", "cos"))
        for limit, modes, allowed in zip(self.known, self.modes, self.allowed, strict=True):
            shares[LIMITS.index(limit)] = np.max(_largest(modes @ sine, modes @ cosine) / allowed)
        return shares


def add_limits(response: xr.Dataset, joint: xr.Dataset) -> xr.Dataset:
    """A response with the share of each limit that is reached at its peaks.

    The motion at a peak has the shape of the first harmonic of the response's own peak, and the
    amplitude of the peak with all harmonics, where that is known.

    Parameters
    ----------
    response
        ``response.nc``.
    joint
        ``joint.nc`` of the same modes, with limits and modes at the places that decide
        (``structure.model_limits``).

    Returns
    -------
    Dataset
        With ``peak_displacement_over_length``, ``peak_slip_over_clearance`` and
        ``peak_stress_over_strength`` (force), not a number without a peak; without those whose
        limit the joint does not know.
    """
    limits = KnownLimits.of(joint)
    if not limits.known:
        return response
    shares = np.full((response.sizes["force"], len(LIMITS)), np.nan)
    for place, force in enumerate(response["force_level"].to_numpy()):
        at = response.isel(force=place)
        at_peak = motion_at_peak(response, force) if np.isfinite(at["peak_amplitude"]) else None
        if at_peak is None:
            continue
        scale = float(at.get("peak_amplitude_converged", np.nan) / at["peak_amplitude"])
        scale = scale if np.isfinite(scale) else 1.0
        shares[place] = scale * limits.reached(at_peak[1])
    of_known = {limit: shares[:, LIMITS.index(limit)] for limit in limits.known}
    return response.assign(
        {
            f"peak_{limit.name}": quantity("force", reached, "1", limit.meaning)
            for limit, reached in of_known.items()
        }
    )


class LimitsReached:
    """The largest shares of the limits in some responses, of which one warning tells."""

    def __init__(self) -> None:
        self._largest: dict[Limit, tuple[float, float]] = {}

    def add(self, response: xr.Dataset) -> None:
        """Note those of a response that ``add_limits`` gave."""
        for limit in LIMITS:
            reached = np.nan_to_num(response.get(f"peak_{limit.name}", np.zeros(0)))
            if reached.size:
                place = int(np.argmax(reached))
                of_response = float(reached[place]), float(response["force_level"][place])
                self._largest[limit] = max(self._largest.get(limit, (0.0, 0.0)), of_response)

    def warn(self) -> None:
        """Warn of each limit that is exceeded."""
        for limit, (share, force) in self._largest.items():
            if problem := limit.told(share):
                logger.warning("%g N: %s", force, problem)


def _largest(sine: Array, cosine: Array) -> Array:
    """Largest lengths on the ellipses ``sine sin(wt) + cosine cos(wt)``, (places,).

    Both have the shape (places, components).
    """
    mean = (np.sum(sine**2, axis=1) + np.sum(cosine**2, axis=1)) / 2
    half = (np.sum(sine**2, axis=1) - np.sum(cosine**2, axis=1)) / 2
    return np.asarray(np.sqrt(mean + np.hypot(half, np.sum(sine * cosine, axis=1))), float)
