"""Families of modes: what a maker names them, or rigid and elastic ones."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

#: family of modes of which nothing else is told
ELASTIC = "elastic"


class Families(NamedTuple):
    """Families of modes and the kinetic energies that decided them.

    ``family`` (modes,); ``energy_share`` (modes, 3): along x, y, z over all of it;
    ``symmetric_share`` (modes,): of motion that is symmetric. The last two are None where the maker
    does not tell families apart.
    """

    family: NDArray[np.str_]
    energy_share: NDArray[np.float64] | None = None
    symmetric_share: NDArray[np.float64] | None = None
