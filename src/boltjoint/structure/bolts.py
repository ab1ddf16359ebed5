"""Preload of the bolts: the tension of each, and its strain against the yield strain.

The model is linear, so it accepts any preload; a preload beyond yield gives a warning.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

#: property class 8.8 of ISO 898-1, 640 MPa, over the Young's modulus of steel, 206 GPa; only a
#: warning depends on it
YIELD_STRAIN = 640e6 / 206e9


def yield_warning(preload: float, area: float, youngs_modulus: float) -> str | None:
    """A sentence where shanks of uniform tension yield, ``N / (E A) > YIELD_STRAIN``, or None.

    Parameters
    ----------
    preload
        N, tension of the bolt [N].
    area
        A, cross-section of the shank [m2].
    youngs_modulus
        E [Pa].
    """
    strain = preload / (youngs_modulus * area)
    if strain <= YIELD_STRAIN:
        return None
    return (
        f"a preload of {preload:g} N strains the shanks by {strain:.2%}, more than the "
        f"{YIELD_STRAIN:.2%} at which steel bolts of class 8.8 yield; the model stays elastic"
    )


def tension_of(preload: float | Sequence[float], bolts: int) -> NDArray[np.float64]:
    """Tension of each bolt [N], from the preload of all or of each.

    Raises
    ------
    ValueError
        If there is not one for each bolt, one is negative, or all are 0.
    """
    if np.ndim(preload) == 0:
        return np.full(bolts, checks.number("preload", preload, above=0))
    tension = checks.array("preload", preload, (bolts,), at_least=0)
    if not tension.any():
        raise ValueError("preload is 0 for all bolts: one must be tightened")
    return tension
