"""Harmonic balance in complex response-dependent nonlinear modes.

An extension of RDNM (``rdnm``): the modes are eigenvectors of the complex symmetric matrix
``A = L + i H(w) + sum_d B_d^T D_d B_d`` with the damping H(w) of the structure and the complex
describing function D_d of each contact point, so that they contain the dissipation. They are
normalised by ``phi^T phi = 1``, without conjugate, by which the modes of a complex symmetric matrix
are orthogonal.
"""

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.balance.balance_equations import BalanceEquations, Jacobian
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.rdnm import (
    matching_modes,
    orientation_of_modes,
    stuck_modes,
)
from boltjoint.solvers.equations import LazyJacobian
from boltjoint.solvers.lagged_basis import LaggedEquations


class ComplexRDNM(BalanceEquations, LaggedEquations):
    """The balance projected onto a few complex modes, with quasi-static residual modes.

    With ``q = Im((s + i c) exp(iwt))``, the unknown is y of ``s + i c = Phi y + q_r``, its real and
    then its imaginary part, after the bias in all linear modes where the law has one; the equations
    are projected with ``Phi^T``. The quasi-static correction q_r is the response of the residual
    modes to the excitation alone, at the last frequency.

    The modes are updated at each predicted point, and tracked by their shape (MAC): their lag is of
    second order in the step. With the quasi-static correction the solution is corrected in all
    linear modes, unless the modes are lagged.

    Parameters
    ----------
    balance
        The modal equations, of one harmonic.
    count, target, jacobian
        As for ``LaggedRDNM``.
    is_lagged
        Whether the modes are updated once a solution, which is not corrected. If not, and without
        the quasi-static correction, a step is repeated until its modes are those of its solution.
    quasi_static_correction
        Whether q_r is added; else it is zero.

    Raises
    ------
    ValueError
        If more modes are asked for than the structure has, or the motion has further harmonics.
    """

    predictive = True

    def __init__(
        self,
        balance: HarmonicBalance,
        count: int,
        target: int = 0,
        jacobian: Jacobian = "analytic",
        is_lagged: bool = False,
        quasi_static_correction: bool = True,
    ) -> None:
        super().__init__(balance, jacobian)
        # a basis of the solution itself, with the residual modes, holds that in all linear modes
        predicts = quasi_static_correction and not is_lagged
        self.implicit = not (is_lagged or predicts)
        self.full_equations = BalanceEquations(balance, jacobian) if predicts else None
        if balance.components[-2:] != ("sin", "cos") or len(balance.components) > 3:
            raise ValueError("complex response-dependent modes need a motion of one harmonic")
        self._modes = len(balance.stiffness)
        self._bias = self._modes * balance.components.has_bias
        self._excitation = balance.joint.excitation.modes * balance.excitation_force
        self._quasi_static_correction = quasi_static_correction
        real = stuck_modes(balance, count, target)[1]
        self.basis = real.astype(complex), np.zeros(self._modes, dtype=complex)

    def compiled_system(self) -> None:
        """None: the basis depends on the response."""
        return None

    @property
    def basis(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Phi, shape (linear modes, modes), and q_r, shape (linear modes,)."""
        return self._phi, self._correction

    @basis.setter
    def basis(self, basis: object) -> None:
        phi, correction = checks.instance("basis", basis, tuple)
        self._phi: NDArray[np.complex128] = phi
        self._correction: NDArray[np.complex128] = correction
        rows, bias = self.balance.contact.rows, self._bias
        shape = self.balance.joint.points, len(rows), len(self.balance.components)
        size = bias + 2 * phi.shape[1]
        # motion of the points by the unknown and by q_r; modal forces by forces of the points
        self._to_points, self._from_points = np.zeros((2, *shape, size))
        self._motion_of_correction = np.zeros(shape)
        for d, B in enumerate(rows):
            Z, z = B @ phi, B @ correction
            self._to_points[:, d, 0, :bias] = self._from_points[:, d, 0, :bias] = B[:, :bias]
            self._to_points[:, d, -2, bias:] = np.hstack([Z.real, -Z.imag])
            self._to_points[:, d, -1, bias:] = np.hstack([Z.imag, Z.real])
            self._from_points[:, d, -2, bias:] = np.hstack([Z.real, Z.imag])
            self._from_points[:, d, -1, bias:] = np.hstack([-Z.imag, Z.real])
            self._motion_of_correction[:, d, -2:] = np.column_stack([z.real, z.imag])

    def evaluate(
        self, x: NDArray[np.float64], p: float, load_factor: float = 1.0
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and Jacobian at the frequency p [rad/s].

        Raises
        ------
        ValueError
            If the load factor is not 1: the modes are those under the whole excitation.
        """
        checks.number("load_factor", load_factor, at_least=1.0, at_most=1.0)
        if not self.is_analytic:
            return self._with_differences(x, p)
        force, tangent = self.balance.joint.law.evaluate_with_tangent(self._motion(x), p)
        return self._residual_under(x, p, force), lambda: self._jacobian(p, tangent)

    def _jacobian(self, p: float, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """The Jacobian from the tangents of the points."""
        phi, bias = self._phi, self._bias
        dynamic = phi.T @ (self.balance.complex_stiffness(p) - p**2 * np.eye(len(phi))) @ phi
        jacobian = self._contact_jacobian(tangent)
        jacobian[:bias, :bias] += self.balance.stiffness_of_mean[:bias, :bias]
        jacobian[bias:, bias:] += np.block(
            [[dynamic.real, -dynamic.imag], [dynamic.imag, dynamic.real]]
        )
        return jacobian

    def _contact_jacobian(self, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """Contribution of the contact to the Jacobian."""
        points, size = len(tangent), self._to_points.shape[-1]
        to_points = self._to_points.reshape(points, -1, size)
        derivative = tangent.reshape(points, to_points.shape[1], -1) @ to_points
        return self._from_points.reshape(-1, size).T @ derivative.reshape(-1, size)

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        _, y = self._parts(x)
        q = self._phi @ y + self._correction
        derivative = -2.0 * p * (self._phi.T @ q)
        if self.balance.damping_matrix.varying is not None:
            derivative += 1j * (self._phi.T @ (self.balance.damping_matrix.derivative.at(p) @ q))
        total = np.concatenate([np.zeros(self._bias), derivative.real, derivative.imag])
        of_contact = self.balance.joint.law.frequency_derivative(self._motion(x), p)
        if of_contact is not None:
            total += of_contact.ravel() @ self._from_points.reshape(of_contact.size, -1)
        return total

    def update(self, q: NDArray[np.float64], p: float) -> None:
        """Update the modes by the describing function at amplitudes of the linear modes."""
        springs = self.balance.describing_function(q, p)
        contact = self.balance.contact.spring_stiffness(springs)
        squared, vectors = np.linalg.eig(self.balance.complex_stiffness(p) + contact)
        vectors /= np.sqrt(np.sum(vectors * vectors, axis=0))
        kept = matching_modes(vectors, self._phi)
        correction = np.zeros_like(self._correction)
        if self._quasi_static_correction:
            residual_modes = np.delete(vectors, kept, axis=1)
            y = residual_modes.T @ self._excitation / (np.delete(squared, kept) - p**2)
            correction = np.asarray(residual_modes @ y, complex)
        phi = vectors[:, kept] * orientation_of_modes(vectors[:, kept], self._phi)
        self.basis = phi, correction

    def from_fixed(
        self, q: NDArray[np.float64], correction: NDArray[np.complex128] | float | None = None
    ) -> NDArray[np.float64]:
        """Project amplitudes of the linear modes, less q_r, onto the present modes."""
        bias, (s, c) = q[: self._bias], q[self._bias :].reshape(2, -1)
        correction = self._correction if correction is None else correction
        y = self._phi.T @ (s + 1j * c - correction)
        return np.concatenate([bias, y.real, y.imag])

    def to_fixed(
        self, x: NDArray[np.float64], correction: NDArray[np.complex128] | float | None = None
    ) -> NDArray[np.float64]:
        """Amplitudes of the linear modes with q_r, components one after another."""
        bias, y = self._parts(x)
        q = self._phi @ y + (self._correction if correction is None else correction)
        return np.concatenate([bias, q.real, q.imag])

    def change_from_fixed(self, dq: NDArray[np.float64]) -> NDArray[np.float64]:
        """A change of the linear modes' amplitudes as one of the unknown."""
        return self.from_fixed(dq, 0.0)

    def change_to_fixed(self, dx: NDArray[np.float64]) -> NDArray[np.float64]:
        """A change of the unknown as one of the linear modes' amplitudes."""
        return self.to_fixed(dx, 0.0)

    def _parts(self, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
        """The bias in linear modes, empty without one, and the amplitudes of the complex modes."""
        real, imaginary = x[self._bias :].reshape(2, -1)
        return x[: self._bias], real + 1j * imaginary

    def _motion(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        motion = self._to_points @ x + self._motion_of_correction
        return motion.reshape(len(motion), -1)

    def _residual(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        return self._residual_under(x, p, self.balance.joint.law.evaluate(self._motion(x), p))

    def _residual_under(
        self, x: NDArray[np.float64], p: float, force: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Residual of the equations under given forces on the contact points."""
        bias, y = self._parts(x)
        q = self._phi @ y + self._correction
        stiffness = self.balance.complex_stiffness(p)
        harmonic = self._phi.T @ (stiffness @ q - p**2 * q - self._excitation)
        static = self.balance.stiffness_of_mean @ bias if bias.size else bias
        contact = force.ravel() @ self._from_points.reshape(force.size, -1)
        return np.concatenate([static, harmonic.real, harmonic.imag]) + contact
