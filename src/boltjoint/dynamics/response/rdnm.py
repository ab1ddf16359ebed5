"""Harmonic balance in real response-dependent nonlinear modes (RDNM).

The modes are eigenvectors of ``A = L + sum_d B_d^T Re(D_d) B_d`` (dual-space form, eq. 2.13 and
2.14), with the describing function D of each contact point and the modal rows B_d of the points.
They are tracked by their shape, with the modal assurance criterion (MAC).

References
----------
R. J. Allemang, D. L. Brown: A correlation coefficient for modal vector analysis. Proceedings of the
1st International Modal Analysis Conference (1982) 110-116.
E. Ferhatoglu, E. Cigeroglu, H. N. Özgüven: A novel modal superposition method with response
dependent nonlinear modes for periodic vibration analysis of large MDOF nonlinear systems.
Mechanical Systems and Signal Processing 135 (2020) 106388.
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: section 2.1.3.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from boltjoint import checks
from boltjoint.dynamics.balance.balance_equations import BalanceEquations, Jacobian
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.solvers.equations import LazyJacobian
from boltjoint.solvers.lagged_basis import LaggedEquations


class LaggedRDNM(BalanceEquations, LaggedEquations):
    """Lagged RDNM: the balance is projected onto the modes of the last solution.

    They are updated after every accepted solution and tracked by their shape (MAC).

    Parameters
    ----------
    balance
        The modal equations.
    count
        Number of modes kept.
    target
        The mode of the stuck structure that must be among them, from 0.
    jacobian
        As for ``BalanceEquations``.

    Raises
    ------
    ValueError
        If more modes are asked for than the structure has.
    """

    predictive = implicit = False
    full_equations = None

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

    def compiled_system(self) -> None:
        """None: the basis depends on the response."""
        return None

    @property
    def basis(self) -> NDArray[np.float64]:
        """The present modes as combinations of the linear ones, shape (linear modes, modes)."""
        return self._basis

    @basis.setter
    def basis(self, basis: object) -> None:
        self._basis = checks.instance("basis", basis, np.ndarray)
        self.balance = self.balance.in_basis(self._basis)

    def update(self, q: NDArray[np.float64], p: float) -> None:
        """Update the modes by the describing function at amplitudes of the linear modes."""
        D = self._linear.describing_function(q, p)
        contact = self._linear.contact.spring_stiffness(D.real)
        vectors = np.linalg.eigh(self._linear.stiffness + contact)[1]
        vectors = vectors[:, matching_modes(vectors, self.basis)]
        self.basis = vectors * orientation_of_modes(vectors, self.basis)

    def from_fixed(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Project amplitudes of the linear modes onto the present modes."""
        return (q.reshape(-1, len(self.basis)) @ self.basis).ravel()

    def to_fixed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Amplitudes of the linear modes, components one after another."""
        return (x.reshape(-1, self.basis.shape[1]) @ self.basis.T).ravel()

    def change_from_fixed(self, dq: NDArray[np.float64]) -> NDArray[np.float64]:
        """As ``from_fixed``."""
        return self.from_fixed(dq)

    def change_to_fixed(self, dx: NDArray[np.float64]) -> NDArray[np.float64]:
        """As ``to_fixed``."""
        return self.to_fixed(dx)


class SelfConsistentRDNM(BalanceEquations):
    """Self-consistent RDNM: modes of the solution itself, an implicit basis update.

    The unknown is the amplitude q of all linear modes. With the modes V of the describing function
    at q, P = V V^T, the residual g of the balance and a stiffness k, every component obeys::

        P g + k (I - P) q = 0

    so that q lies in the span of its own modes and the balance holds in them. The Jacobian contains
    the derivative of the modes: with ``A v_i = a_i v_i`` and the residual modes v_j,
    ``dv_i = sum_j (v_j . dA v_i) / (a_i - a_j) v_j``.

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
        #: modes evaluated last: the solution, the modes they continue, the modes
        self._found: tuple[NDArray[np.float64], ...] | None = None
        #: frequency of the last evaluation, at which the modes are those of the describing function
        self._w = 0.0

    def compiled_system(self) -> None:
        """None: the basis depends on the response."""
        return None

    def in_all_modes(self, reduced: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """None: all are in the modes of the solution itself."""
        return np.zeros_like(reduced)

    def state(self) -> NDArray[np.float64]:
        """The modes at the last accepted solution, by which those at the next are tracked."""
        return self._modes

    def restore(self, state: object) -> None:
        """Return to the modes at an earlier solution."""
        self._modes = checks.instance("state", state, np.ndarray)

    def evaluate(
        self, x: NDArray[np.float64], p: float, load_factor: float = 1.0
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and Jacobian at the frequency p [rad/s], under a part of the excitation."""
        contact, motion = self.balance.contact, self.balance.motion(x)
        force, tangent = self.balance.joint.law.evaluate_with_tangent(motion, p)
        D = contact.describing_function(motion, force)
        squared, vectors, kept = self._modes_of(D)
        V, k = vectors[:, kept], self._scale
        self._found, self._w = (x, self._modes, V), p
        residual, linear_jacobian = self.balance.assemble(x, p, force, tangent)
        residual += (1 - load_factor) * self.balance.modal_force
        h = (residual - k * x).reshape(-1, len(V))

        def jacobian() -> NDArray[np.float64]:
            others = np.delete(vectors, kept, axis=1)
            gaps = squared[kept] - np.delete(squared, kept)[:, None]
            dD = contact.describing_function_derivative(motion, D, tangent).real
            # derivatives of the modes by q, each (linear modes, components * linear modes)
            dV = [
                others @ (others.T @ contact.spring_force_derivative(v, dD) / gap[:, None])
                for v, gap in zip(V.T, gaps.T, strict=True)
            ]
            matrix = linear_jacobian() - k * np.eye(x.size)
            for part, h_part in zip(matrix.reshape(*h.shape, -1), h, strict=True):
                part[:] = V @ (V.T @ part)
                for v, dv in zip(V.T, dV, strict=True):
                    part += dv * (v @ h_part) + np.outer(v, h_part @ dv)
            return matrix + k * np.eye(x.size)

        return (h @ V @ V.T).ravel() + k * x, jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        return self._projected(x, super().parameter_derivative(x, p))

    def load_factor_derivative(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of the residual by the load factor."""
        return -self._projected(x, self.balance.modal_force)

    def accept(self, x: NDArray[np.float64]) -> None:
        """Remember the modes at x."""
        self._modes = self._modes_at(x)

    def _projected(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        V = self._modes_at(x)
        return (y.reshape(-1, len(V)) @ V @ V.T).ravel()

    def _modes_at(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._found is None or self._found[0] is not x or self._found[1] is not self._modes:
            _, vectors, kept = self._modes_of(self.balance.describing_function(x, self._w))
            self._found = x, self._modes, vectors[:, kept]
        return self._found[2]

    def _modes_of(
        self, D: NDArray[np.complex128]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Squared frequencies, all modes, and the indices of those that continue the last ones."""
        contact = self.balance.contact.spring_stiffness(D.real)
        squared, vectors = np.linalg.eigh(self.balance.stiffness + contact)
        kept = matching_modes(vectors, self._modes)
        vectors[:, kept] *= orientation_of_modes(vectors[:, kept], self._modes)
        return squared, vectors, kept


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
