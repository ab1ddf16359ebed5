"""Harmonic balance in complex response-dependent nonlinear modes."""

from typing import get_args

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.linear_modes import Jacobian, LinearModes
from boltjoint.dynamics.mode_tracking import matching_modes, orientation_of_modes, stuck_modes
from boltjoint.dynamics.rdnm import BasisUpdate
from boltjoint.solvers.equations import LazyJacobian
from boltjoint.solvers.lagged_basis import LaggedEquations


class ComplexRDNM(LinearModes, LaggedEquations):
    """A few complex modes of the structure as the contact's present force makes it.

    Eigenvectors of the complex symmetric ``A = L (1 + i eta) + R^T D R``, D the complex describing
    function of each contact point, so that they hold what the contact dissipates. They are
    normalised by ``phi^T phi = 1`` and the equations are projected with ``phi^T``, no conjugate, by
    which the modes of a complex symmetric matrix are orthogonal. After every accepted solution they
    are renewed at the point that is expected next, and followed by their shape: so what they lag
    behind is of second order in the step.

    With ``q = Im((s + i c) exp(iwt))``, the unknown is y of ``s + i c = Phi y + q_rest``, its real
    and then its imaginary part, after the bias in all linear modes where the law has one. q_rest is
    what the modes left out add when they see the excitation alone, at the last frequency.

    Parameters
    ----------
    balance
        The modal equations, of one harmonic.
    count, target, jacobian
        As for ``LaggedRDNM``.
    basis_update
        Whether a solution is sought again, in modes renewed where it was found, until they belong
        to it (``within``), or the modes are renewed once for each solution (``after``).
    quasi_static_correction
        Whether q_rest is added, else it is zero.

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
        basis_update: BasisUpdate = "within",
        quasi_static_correction: bool = True,
    ) -> None:
        super().__init__(balance, jacobian)
        checks.choice("basis_update", basis_update, get_args(BasisUpdate))
        quasi_static_correction = checks.flag("quasi_static_correction", quasi_static_correction)
        self.implicit = basis_update == "within"
        # with all others added, a basis of the solution itself is as good as the linear modes
        exact = self.implicit and quasi_static_correction
        self.full = LinearModes(balance, jacobian) if exact else None
        if balance.components[-2:] != ("sin", "cos") or len(balance.components) > 3:
            raise ValueError("complex response-dependent modes need a motion of one harmonic")
        self._modes = len(balance.stiffness)
        self._bias = self._modes * (balance.components[0] == "bias")
        self._excitation = balance.joint.excitation_mode * balance.excitation_force
        self._lossy = balance.stiffness * (1 + 1j * balance.loss_factor)
        self._quasi_static_correction = quasi_static_correction
        real = stuck_modes(balance, count, target)[1]
        self.basis = real.astype(complex), np.zeros(self._modes, dtype=complex)

    @property
    def basis(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Phi, shape (linear modes, modes), and q_rest, shape (linear modes,)."""
        return self._phi, self._rest

    @basis.setter
    def basis(self, basis: tuple[NDArray[np.complex128], NDArray[np.complex128]]) -> None:
        self._phi, self._rest = phi, rest = basis
        rows, bias = self.balance.rows, self._bias
        shape = self.balance.joint.points, len(rows), len(self.balance.components)
        size = bias + 2 * phi.shape[1]
        # motion of the points: by the unknown, and at rest; modal forces by those of the points
        self._to_points, self._from_points = np.zeros((2, *shape, size))
        self._points_at_zero = np.zeros(shape)
        for d, B in enumerate(rows):
            Z, at_zero = B @ phi, B @ rest
            self._to_points[:, d, 0, :bias] = self._from_points[:, d, 0, :bias] = B[:, :bias]
            self._to_points[:, d, -2, bias:] = np.hstack([Z.real, -Z.imag])
            self._to_points[:, d, -1, bias:] = np.hstack([Z.imag, Z.real])
            self._from_points[:, d, -2, bias:] = np.hstack([Z.real, Z.imag])
            self._from_points[:, d, -1, bias:] = np.hstack([-Z.imag, Z.real])
            self._points_at_zero[:, d, -2:] = np.column_stack([at_zero.real, at_zero.imag])

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual at the frequency p [rad/s], and what forms its Jacobian."""
        if not self._analytic:
            return self._with_differences(x, p)
        force, tangent = self.balance.joint.law.evaluate_with_tangent(self._motion(x))
        return self._balanced(x, p, force), lambda: self._jacobian(p, tangent)

    def _jacobian(self, p: float, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """The Jacobian from the tangents of the points."""
        phi, bias = self._phi, self._bias
        dynamic = phi.T @ (self._lossy - p**2 * np.eye(len(phi))) @ phi
        jacobian = self._contact_jacobian(tangent)
        jacobian[:bias, :bias] += self.balance.stiffness[:bias, :bias]
        jacobian[bias:, bias:] += np.block(
            [[dynamic.real, -dynamic.imag], [dynamic.imag, dynamic.real]]
        )
        return jacobian

    def _contact_jacobian(self, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the contact adds to the Jacobian, bias and harmonics apart."""
        points, size = len(tangent), self._to_points.shape[-1]
        forth, back = (of.reshape(points, -1, size) for of in (self._to_points, self._from_points))
        changes = tangent.reshape(points, forth.shape[1], -1) @ forth
        return np.tensordot(back, changes, ([0, 1], [0, 1]))

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        _, y = self._parts(x)
        derivative = -2.0 * p * (self._phi.T @ (self._phi @ y + self._rest))
        return np.concatenate([np.zeros(self._bias), derivative.real, derivative.imag])

    def update(self, q: NDArray[np.float64], p: float) -> None:
        """New modes from the describing function at amplitudes of the linear modes."""
        secant = self.balance.secant_stiffness(q)
        matrix = self.balance.stiffness_with(secant) + 1j * self._lossy.imag
        squared, vectors = np.linalg.eig(matrix)
        vectors /= np.sqrt(np.sum(vectors * vectors, axis=0))
        kept = matching_modes(vectors, self._phi)
        rest = np.zeros_like(self._rest)
        if self._quasi_static_correction:
            others = np.delete(vectors, kept, axis=1)
            share = others.T @ self._excitation / (np.delete(squared, kept) - p**2)
            rest = others @ share
        self.basis = vectors[:, kept] * orientation_of_modes(vectors[:, kept], self._phi), rest

    def from_fixed(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Project amplitudes of the linear modes onto the present modes."""
        return self._from_fixed(q, self._rest)

    def to_fixed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The unknown as amplitude of the linear modes, components one after another."""
        return self._to_fixed(x, self._rest)

    def change_from_fixed(self, dq: NDArray[np.float64]) -> NDArray[np.float64]:
        """A change of the linear modes' amplitudes as one of the unknown."""
        return self._from_fixed(dq, 0.0)

    def change_to_fixed(self, dx: NDArray[np.float64]) -> NDArray[np.float64]:
        """A change of the unknown as one of the linear modes' amplitudes."""
        return self._to_fixed(dx, 0.0)

    def _from_fixed(
        self, q: NDArray[np.float64], rest: NDArray[np.complex128] | float
    ) -> NDArray[np.float64]:
        bias, (s, c) = q[: self._bias], q[self._bias :].reshape(2, -1)
        y = self._phi.T @ (s + 1j * c - rest)
        return np.concatenate([bias, y.real, y.imag])

    def _to_fixed(
        self, x: NDArray[np.float64], rest: NDArray[np.complex128] | float
    ) -> NDArray[np.float64]:
        bias, y = self._parts(x)
        q = self._phi @ y + rest
        return np.concatenate([bias, q.real, q.imag])

    def _parts(self, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
        """The bias in linear modes, empty without one, and the amplitudes of the complex modes."""
        real, imaginary = x[self._bias :].reshape(2, -1)
        return x[: self._bias], real + 1j * imaginary

    def _motion(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        motion = self._to_points @ x + self._points_at_zero
        return motion.reshape(len(motion), -1)

    def _residual(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        return self._balanced(x, p, self.balance.joint.law.evaluate(self._motion(x)))

    def _balanced(
        self, x: NDArray[np.float64], p: float, force: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """What is left of the equations when the contact has this force on its points."""
        bias, y = self._parts(x)
        q = self._phi @ y + self._rest
        left = self._phi.T @ (self._lossy @ q - p**2 * q - self._excitation)
        static = self.balance.stiffness @ bias if bias.size else bias
        contact = force.ravel() @ self._from_points.reshape(force.size, -1)
        return np.concatenate([static, left.real, left.imag]) + contact
