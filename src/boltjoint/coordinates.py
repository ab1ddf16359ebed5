"""In which coordinates is the balance solved? Linear modes, or modes that depend on the response.

Every kind of coordinates poses the equations that ``continuation`` follows, and translates its
unknown back into the linear modes of the structure.
"""

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from boltjoint.balance import HarmonicBalance
from boltjoint.names import parse_coordinates

Jacobian = Literal["analytic", "forward-difference"]

#: forward differences step by this share of the unknown's size: the square root of rounding
_DIFFERENCE = float(np.sqrt(np.finfo(float).eps))


class LinearModes:
    """The modes of the structure without contact, all of them (MSM, section 2.1.2).

    Parameters
    ----------
    balance
        The modal equations.
    jacobian
        ``analytic``, or ``forward-difference`` as in eq. 2.38.
    """

    def __init__(self, balance: HarmonicBalance, jacobian: Jacobian = "analytic") -> None:
        self.balance = balance
        self.residual_scale = float(np.linalg.norm(balance.modal_force))
        self._analytic = jacobian == "analytic"

    @property
    def basis(self) -> NDArray[np.float64] | None:
        """The modes that the unknown stands for, combined from the linear ones; None for those."""
        return self.balance.basis

    @basis.setter
    def basis(self, basis: NDArray[np.float64] | None) -> None:
        self.balance = replace(self.balance, basis=basis)

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Residual and Jacobian at the frequency p [rad/s]."""
        if self._analytic:
            return self.balance.residual_and_jacobian(x, p)
        residual = self.balance.residual(x, p)
        jacobian = np.empty((x.size, x.size))
        size = np.linalg.norm(x) / np.sqrt(x.size) or 1.0
        for j in range(x.size):
            step = _DIFFERENCE * max(abs(x[j]), size)
            moved = x.copy()
            moved[j] += step
            jacobian[:, j] = (self.balance.residual(moved, p) - residual) / (moved[j] - x[j])
        return residual, jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        return self.balance.frequency_derivative(x, p)

    def renew(self, x: NDArray[np.float64], p: float, along: NDArray[np.float64]) -> None:
        """Linear modes stay what they are."""

    def from_fixed(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """The unknown that is nearest to given amplitudes of the linear modes."""
        return q

    def to_fixed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The unknown as amplitude of the linear modes, components one after another."""
        return x


class ResponseDependentModes(LinearModes):
    """A few modes of the structure as the contact's present stiffness makes it (RDNM, 2.1.3).

    The modes are eigenvectors of ``L + R^T Re(D) R`` (dual-space form, eq. 2.13 and 2.14), D the
    describing function of each contact point at the last solution. They are renewed after every
    accepted solution and followed by their shape. The equations are projected onto them.

    Parameters
    ----------
    balance
        The modal equations.
    count
        Number of modes kept.
    target
        The mode of the stuck structure that must be among them, from 0.
    jacobian
        As for ``LinearModes``.

    Raises
    ------
    ValueError
        If more modes are asked for than the structure has.
    """

    def __init__(
        self,
        balance: HarmonicBalance,
        count: int,
        target: int = 0,
        jacobian: Jacobian = "analytic",
    ) -> None:
        super().__init__(balance, jacobian)
        modes = len(balance.stiffness)
        if not 1 <= count <= modes:
            raise ValueError(f"{count} response-dependent modes of {modes} linear ones")
        first = max(0, target + 1 - count)
        self._linear = balance
        stuck = balance.stiffness + balance.joint.stuck_stiffness()
        self.basis = np.linalg.eigh(stuck)[1][:, first : first + count]

    def renew(
        self, x: NDArray[np.float64], p: float, along: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """New modes from the describing function at x; x and a direction projected onto them."""
        q, q_along = self.to_fixed(x), self.to_fixed(along)
        matrix = self._linear.stiffness
        secant = self.balance.secant_stiffness(x).real
        for B, k in zip(self._linear.rows, secant.T, strict=True):
            matrix = matrix + B.T @ (k[:, None] * B)
        self.basis = _followed(np.linalg.eigh(matrix)[1], self.basis)
        return self.from_fixed(q), self.from_fixed(q_along)

    def from_fixed(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Project amplitudes of the linear modes onto the present modes."""
        return (q.reshape(-1, len(self.basis)) @ self.basis).ravel()

    def to_fixed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The unknown as amplitude of the linear modes, components one after another."""
        return (x.reshape(-1, self.basis.shape[1]) @ self.basis.T).ravel()


def pose(
    name: str, balance: HarmonicBalance, resonance: int, jacobian: Jacobian = "analytic"
) -> LinearModes:
    """Pose the balance in coordinates by their name, ``linear`` or ``rdnm-N``.

    Parameters
    ----------
    name
        The coordinates.
    balance
        The modal equations.
    resonance
        The resonance that is followed, from 1.
    jacobian
        As for ``LinearModes``.

    Raises
    ------
    ValueError
        If there are no such coordinates.
    """
    count = parse_coordinates(name)
    if count is None:
        return LinearModes(balance, jacobian)
    return ResponseDependentModes(balance, count, resonance - 1, jacobian)


def _followed(vectors: NDArray[np.float64], previous: NDArray[np.float64]) -> NDArray[np.float64]:
    """Those columns that best continue the previous ones in shape, and their sign."""
    likeness = previous.T @ vectors
    _, columns = linear_sum_assignment(-np.abs(likeness))
    signs = np.sign(likeness[np.arange(len(columns)), columns])
    return vectors[:, columns] * np.where(signs == 0, 1.0, signs)
