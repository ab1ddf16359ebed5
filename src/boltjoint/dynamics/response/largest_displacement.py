"""Displacements at peaks over the length of the structure: where its linear model ends."""

import logging

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.dataset import quantity
from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.structure.extent import LINEAR

logger = logging.getLogger(__name__)


def add_largest_displacement(response: xr.Dataset, joint: xr.Dataset) -> xr.Dataset:
    """A response with the largest displacement at each of its peaks, over the structure's length.

    The motion at a peak has the shape of the first harmonic of the response's own peak, and the
    amplitude of the peak with all harmonics, where that is known.

    Parameters
    ----------
    response
        ``response.nc``.
    joint
        ``joint.nc`` of the same modes, with ``structure_length`` and ``farthest_mode``
        (``structure.extent``).

    Returns
    -------
    Dataset
        With ``peak_displacement_over_length`` (force), not a number without a peak; the same
        without these of the joint. A warning tells the largest beyond ``LINEAR``.
    """
    if "farthest_mode" not in joint:
        return response
    length = float(joint["structure_length"])
    modes = joint["farthest_mode"].transpose("farthest", "axis", "mode").to_numpy()
    shares = np.full(response.sizes["force"], np.nan)
    for place, force in enumerate(response["force_level"].to_numpy()):
        at = response.isel(force=place)
        at_peak = motion_at_peak(response, force) if np.isfinite(at["peak_amplitude"]) else None
        if at_peak is None:
            continue
        _, motion = at_peak
        sine, cosine = motion.in_components(("sin", "cos"))
        scale = float(at.get("peak_amplitude_converged", np.nan) / at["peak_amplitude"])
        scale = scale if np.isfinite(scale) else 1.0
        shares[place] = scale * _largest(modes @ sine, modes @ cosine) / length
    largest = np.nan_to_num(shares).max(initial=0.0)
    if largest > LINEAR:
        force = float(response["force_level"][np.nanargmax(shares)])
        logger.warning(
            "%g N: the structure moves by %.0f %% of its length at the peak, which a linear model "
            "does not hold: beyond %.0f %% peaks are those of small displacements",
            force,
            100 * largest,
            100 * LINEAR,
        )
    meaning = "largest displacement at the peak over the length of the structure"
    share = quantity("force", shares, "1", meaning)
    return response.assign(peak_displacement_over_length=share)


def _largest(sine: NDArray[np.float64], cosine: NDArray[np.float64]) -> float:
    """Largest distance on the ellipses ``sine sin(wt) + cosine cos(wt)``, each (points, 3)."""
    mean = (np.sum(sine**2, axis=1) + np.sum(cosine**2, axis=1)) / 2
    half = (np.sum(sine**2, axis=1) - np.sum(cosine**2, axis=1)) / 2
    return float(np.sqrt(mean + np.hypot(half, np.sum(sine * cosine, axis=1))).max())
