"""Bolts: the tension of each, its strain against the yield strain, and distances from their axes.

The model is linear, so it accepts any preload; a preload beyond yield gives a warning.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.structure.model import Bolt

Array = NDArray[np.float64]

#: property class 8.8 of ISO 898-1, 640 MPa, over the Young's modulus of steel, 206 GPa; only the
#: warning of bolts of unknown strength depends on it
YIELD_STRAIN = 640e6 / 206e9
#: Young's modulus below which shanks are of no steel [Pa]
_SOFTEST_STEEL = 180e9


def yield_warning(
    preload: float, area: float, youngs_modulus: float, strength: float | None = None
) -> str | None:
    """A sentence where shanks of uniform tension yield, ``N / A > S``, or None.

    Parameters
    ----------
    preload
        N, tension of the bolt [N].
    area
        A, cross-section of the shank [m2].
    youngs_modulus
        E [Pa].
    strength
        S, yield strength [Pa]; E times ``YIELD_STRAIN`` by default.
    """
    share = share_of_yield(preload, area, youngs_modulus, strength)
    if share <= 1:
        return None
    strain = preload / (youngs_modulus * area)
    of_class = "steel bolts of class 8.8"
    of = of_class if strength is None else f"bolts of {1e-6 * strength:g} MPa (yield_strength_MPa)"
    unsure = strength is None and youngs_modulus < _SOFTEST_STEEL
    return (
        f"a preload of {preload:g} N strains the shanks by {strain:.2%}, more than the "
        f"{strain / share:.2%} at which {of} yield; the model stays elastic"
        f"{', and has no steel bolts: bolts.material gives them' if unsure else ''}"
    )


def share_of_yield(
    preload: float, area: float, youngs_modulus: float, strength: float | None = None
) -> float:
    """Stress of shanks over their yield strength: arguments are those of ``yield_warning``."""
    return preload / area / (YIELD_STRAIN * youngs_modulus if strength is None else strength)


def tension_of(preload: float | Sequence[float], bolts: int) -> Array:
    """Tension of each bolt [N], from the preload of all or of each (files: ``names.Preload``).

    Raises
    ------
    ValueError
        If there is not one for each bolt, one is negative, or all are 0.
    """
    if checks.is_number(preload):
        return np.full(bolts, checks.number("preload", preload, above=0))
    tension = checks.array("preload", preload, (bolts,), at_least=0)
    if not tension.any():
        raise ValueError("preload is 0 for all bolts: one must be tightened")
    return tension


def distance_to_bolts(bolts: Sequence[Bolt], position: Array) -> Array | None:
    """Distance of places from the nearest axis of a bolt [m], shape (places,).

    None where no bolt has an axis and a point on it.

    Parameters
    ----------
    bolts
        Bolts of a structure.
    position
        Places [m], shape (places, 3).
    """
    distances = []
    for bolt in bolts:
        if bolt.axis is not None and bolt.position is not None:
            axis = bolt.axis / np.linalg.norm(bolt.axis)
            apart = position - bolt.position
            along = (apart @ axis)[:, None] * axis
            distances.append(np.linalg.norm(apart - along, axis=1))
    return np.min(distances, axis=0) if distances else None
