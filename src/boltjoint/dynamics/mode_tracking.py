"""Mode tracking by shape, with the modal assurance criterion (MAC).

References
----------
R. J. Allemang, D. L. Brown: A correlation coefficient for modal vector analysis. Proceedings of the
1st International Modal Analysis Conference (1982) 110-116.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from boltjoint import checks
from boltjoint.dynamics.harmonic_balance import HarmonicBalance


def stuck_modes(
    balance: HarmonicBalance, count: int, target: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Squared frequencies and modes of the stuck structure: the target and those next below it."""
    modes = len(balance.stiffness)
    checks.whole("target", target, at_least=0, below=modes)
    if not 1 <= checks.whole("count", count) <= modes:
        raise ValueError(f"{count} response-dependent modes of {modes} linear ones")
    first = max(0, target + 1 - count)
    squared, vectors = np.linalg.eigh(balance.stiffness + balance.joint.stuck_stiffness())
    return squared[first : first + count], vectors[:, first : first + count]


def matching_modes(vectors: NDArray, previous: NDArray) -> NDArray[np.int64]:
    """Columns that best continue each of the previous ones in shape, by the square root of MAC.

    The sum over all pairs is largest, so that no mode continues two.
    """
    correlation = np.abs(previous.conj().T @ vectors) / np.linalg.norm(vectors, axis=0)
    return linear_sum_assignment(-correlation)[1]


def orientation_of_modes(vectors: NDArray, previous: NDArray) -> NDArray[np.float64]:
    """+1 or -1 for each column, so that its sign continues that of the previous one."""
    return np.where(np.sum(previous * vectors, axis=0).real < 0, -1.0, 1.0)
