"""Harmonic balance in real response-dependent nonlinear modes (RDNM)."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.linear_modes import Jacobian, LinearModes
from boltjoint.dynamics.mode_tracking import matching_modes, orientation_of_modes, stuck_modes
from boltjoint.solvers.equations import LazyJacobian
from boltjoint.solvers.lagged_basis import LaggedEquations

BasisUpdate = Literal["within", "after"]


class LaggedRDNM(LinearModes, LaggedEquations):
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

    predictive = implicit = False
    full = None

    def __init__(
        self,
        balance: HarmonicBalance,
        count: int,
        target: int = 0,
        jacobian: Jacobian = "analytic",
    ) -> None:
        super().__init__(balance, jacobian)
        self._linear = balance
        self.basis = stuck_modes(balance, count, target)[1]

    @property
    def basis(self) -> NDArray[np.float64]:
        """The modes that the unknown stands for, combined from the linear ones."""
        return self.balance.basis

    @basis.setter
    def basis(self, basis: NDArray[np.float64]) -> None:
        self.balance = self.balance.in_basis(basis)

    def update(self, q: NDArray[np.float64], p: float) -> None:
        """New modes from the describing function at amplitudes of the linear modes."""
        matrix = self._linear.stiffness_with(self._linear.secant_stiffness(q).real)
        vectors = np.linalg.eigh(matrix)[1]
        vectors = vectors[:, matching_modes(vectors, self.basis)]
        self.basis = vectors * orientation_of_modes(vectors, self.basis)

    def from_fixed(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Project amplitudes of the linear modes onto the present modes."""
        return (q.reshape(-1, len(self.basis)) @ self.basis).ravel()

    def to_fixed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The unknown as amplitude of the linear modes, components one after another."""
        return (x.reshape(-1, self.basis.shape[1]) @ self.basis.T).ravel()

    change_from_fixed, change_to_fixed = from_fixed, to_fixed


class SelfConsistentRDNM(LinearModes):
    """The same modes, of the describing function at the solution itself, not at the one before it.

    The unknown stays the amplitude q of all linear modes. With P = V V^T, V the modes that q makes,
    g the left side of the balance and k a stiffness that makes the units agree, every component
    obeys::

        P g + k (I - P) q = 0

    q lies in the span of its own modes, and the balance holds in them. The derivative knows that
    the modes move with q: with ``A v_i = a_i v_i``,
    ``dv_i = sum over the modes left out, (v_j . dA v_i) / (a_i - a_j) v_j``.

    Parameters
    ----------
    balance, count, target
        As for ``LaggedRDNM``.

    Raises
    ------
    ValueError
        If more modes are asked for than the structure has.
    """

    def __init__(self, balance: HarmonicBalance, count: int, target: int = 0) -> None:
        super().__init__(balance)
        squared, self._modes = stuck_modes(balance, count, target)
        self._scale = squared[-1]
        #: where the modes were asked for last, what they continue, and what they are
        self._found: tuple[NDArray[np.float64], ...] | None = None

    @property
    def tracked(self) -> NDArray[np.float64]:
        """The modes at the last solution, by which those at the next are known again."""
        return self._modes

    @tracked.setter
    def tracked(self, modes: NDArray[np.float64]) -> None:
        self._modes = modes

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual at the frequency p [rad/s], and what forms its Jacobian."""
        motion = self.balance.motion(x)
        force, tangent = self.balance.joint.law.evaluate_with_tangent(motion)
        secant = self.balance.secants(motion, force)
        squared, vectors, kept = self._modes_of(secant.real)
        V, k = vectors[:, kept], self._scale
        self._found = x, self._modes, V
        residual, jacobian_in_all = self.balance.with_contact(x, p, force, tangent)
        residual += (1 - self.share) * self.balance.modal_force
        h = (residual - k * x).reshape(-1, len(V))

        def jacobian() -> NDArray[np.float64]:
            others = np.delete(vectors, kept, axis=1)
            gaps = squared[kept] - np.delete(squared, kept)[:, None]
            # what turns each mode towards those left out, by q: (modes, components * modes)
            change = self.balance.secant_derivative(motion, secant, tangent).real
            turns = [
                others @ (others.T @ self.balance.weighted_products(v, change) / gap[:, None])
                for v, gap in zip(V.T, gaps.T, strict=True)
            ]
            found = jacobian_in_all() - k * np.eye(x.size)
            for part, of_part in zip(found.reshape(*h.shape, -1), h, strict=True):
                part[:] = V @ (V.T @ part)
                for v, turn in zip(V.T, turns, strict=True):
                    part += turn * (v @ of_part) + np.outer(v, of_part @ turn)
            return found + k * np.eye(x.size)

        return (h @ V @ V.T).ravel() + k * x, jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        return self._projected(x, super().parameter_derivative(x, p))

    def share_derivative(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of the residual by the share of the excitation that acts."""
        return -self._projected(x, self.balance.modal_force)

    def accept(self, x: NDArray[np.float64]) -> None:
        """Remember the modes at x."""
        self._modes = self._modes_at(x)

    def _projected(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        V = self._modes_at(x)
        return (y.reshape(-1, len(V)) @ V @ V.T).ravel()

    def _modes_at(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._found is None or self._found[0] is not x or self._found[1] is not self._modes:
            _, vectors, kept = self._modes_of(self.balance.secant_stiffness(x).real)
            self._found = x, self._modes, vectors[:, kept]
        return self._found[2]

    def _modes_of(
        self, secant: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Squared frequencies and modes, and which of them continue the last ones in shape."""
        squared, vectors = np.linalg.eigh(self.balance.stiffness_with(secant))
        kept = matching_modes(vectors, self._modes)
        vectors[:, kept] *= orientation_of_modes(vectors[:, kept], self._modes)
        return squared, vectors, kept
