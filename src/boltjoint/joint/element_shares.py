"""Elements of a fit as softmax shares of the total stiffness and slip force of a region."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax

Array = NDArray[np.float64]


def rounded_shares(values: Array) -> Array:
    """Shares of the total, to 33 binary digits.

    Regions whose elements differ by a factor and by rounding then have the same fit, where the
    search for it would take another way and end in another of several that are equally good.
    """
    mantissa, exponent = np.frexp(values / values.sum())
    return np.ldexp(np.round(np.ldexp(mantissa, 33)), exponent - 33)


class ElementShares:
    """Elements by unknowns x = (a, b): ``k = K softmax(a)``, ``mu N = S softmax(b)``.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region, whose totals are K and S [N/m], [N],
        shape (many,).
    """

    def __init__(self, stiffness: Array, slip_force: Array) -> None:
        self.total_stiffness, self.total_slip = stiffness.sum(), slip_force.sum()

    def elements(self, unknown: Array) -> tuple[Array, Array]:
        """Stiffness and slip force of the elements, each of shape (elements,)."""
        a, b = np.split(unknown, 2)
        return self.total_stiffness * softmax(a), self.total_slip * softmax(b)

    def by_unknown(self, k: Array, s: Array, by_k: Array, by_s: Array) -> Array:
        """Derivatives by x from those by stiffness and slip force, by the chain rule."""
        by_a = by_k * k - np.outer(by_k @ k, k) / self.total_stiffness
        by_b = by_s * s - np.outer(by_s @ s, s) / self.total_slip
        return np.hstack([by_a, by_b])
