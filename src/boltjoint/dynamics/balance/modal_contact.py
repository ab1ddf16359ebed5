"""Friction elements of a joint in modal coordinates: forces, tangents, describing functions."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint.harmonics import Components
from boltjoint.joint.parts import Contact
from boltjoint.solvers.equations import Derivative

#: with more modes, products of two at every point take more time to read than to form
_LARGEST_PRODUCTS = 16

#: points whose tangents are projected together, so that their products stay in the cache
_POINTS_AT_ONCE = 256


@dataclass(frozen=True)
class ModalContact:
    """Contact of a joint, as the harmonic balance in modal coordinates needs it.

    With the modal rows B_d of the contact points in each direction d, the points move by
    ``B_d q`` and their forces f_d act on the modes as ``sum_d B_d^T f_d``, alike for every
    harmonic component.

    Parameters
    ----------
    contact
        Contact points and friction elements of a joint.
    basis
        V of ``q = V x``, shape (linear modes, modes); the linear modes themselves by default.
    """

    contact: Contact
    basis: NDArray[np.float64] | None = None

    @cached_property
    def components(self) -> Components:
        """Harmonic components in the order of the unknown."""
        return Components(self.contact.law.components)

    @cached_property
    def rows(self) -> tuple[NDArray[np.float64], ...]:
        """Relative modes of the contact points in each direction [kg^-1/2], (points, modes)."""
        return tuple(B if self.basis is None else B @ self.basis for B in self.contact.rows)

    @cached_property
    def modes(self) -> int:
        """Number of modes."""
        return self.rows[0].shape[1]

    @cached_property
    def stuck_stiffness(self) -> NDArray[np.float64]:
        """Modal stiffness while nothing slips [s^-2], shape (components * modes,) * 2."""
        stuck = self.contact.stuck_stiffness()
        stuck = stuck if self.basis is None else self.basis.T @ stuck @ self.basis
        return self.components.of_each(stuck)

    def motion(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Relative motion of the contact points [m], shape (points, directions * components)."""
        amplitudes = self._amplitudes(x)
        return np.hstack([B @ amplitudes.T for B in self.rows])

    def _amplitudes(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Amplitudes of the modes, shape (components, modes)."""
        if x.shape != (size := (len(self.components) * self.modes,)):
            raise ValueError(f"x has shape {x.shape}, expected {size}")
        return self.components.rows(x)

    def force(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """Forces on the modes at x [kg^-1/2 N] and the frequency w [rad/s], shape of x."""
        if (in_modes := self._summed_in_modes(x, w)) is not None:
            return in_modes[0]
        return self.modal_force(self.contact.law.evaluate(self.motion(x), w))

    def force_and_tangent(
        self, x: NDArray[np.float64], w: float
    ) -> tuple[NDArray[np.float64], Derivative]:
        """Forces on the modes at x [kg^-1/2 N], and their lazily evaluated derivative [s^-2]."""
        if (in_modes := self._summed_in_modes(x, w)) is not None:
            return in_modes
        force, tangent = self.contact.law.evaluate_with_tangent(self.motion(x), w)
        derivative = Derivative(
            lambda _: self.modal_tangent(tangent), lambda dx: self.change(dx, tangent)
        )
        return self.modal_force(force), derivative

    def _summed_in_modes(
        self, x: NDArray[np.float64], w: float
    ) -> tuple[NDArray[np.float64], Derivative] | None:
        """As ``force_and_tangent`` by sums in modal coordinates; None of laws without them."""
        amplitudes = self._amplitudes(x)
        in_modes = self.contact.law.modal_force_and_tangent(self.rows, amplitudes, w)
        if in_modes is None:
            return None
        force, tangent = in_modes
        derivative = Derivative(
            lambda precision: tangent(precision).reshape(x.size, x.size),
            lambda dx: tangent.along(dx.reshape(amplitudes.shape)).ravel(),
        )
        return force.ravel(), derivative

    def frequency_derivative(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64] | None:
        """Derivative of the forces on the modes by w; None where they do not depend on it."""
        if not self._depends_on_frequency:
            return None
        derivative = self.contact.law.frequency_derivative(self.motion(x), w)
        return None if derivative is None else self.modal_force(derivative)

    @cached_property
    def _depends_on_frequency(self) -> bool:
        at_rest = np.zeros((self.contact.points, len(self.rows) * len(self.components)))
        return self.contact.law.frequency_derivative(at_rest, 1.0) is not None

    def change(self, dx: NDArray[np.float64], tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of the forces on the modes along dx, from the tangents of the points."""
        return self.modal_force((tangent @ self.motion(dx)[:, :, None])[:, :, 0])

    def modal_force(self, force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Forces of the points on the modes [kg^-1/2 N], shape (components * modes,)."""
        n = len(self.components)
        of_directions = (force[:, d * n : (d + 1) * n].T @ B for d, B in enumerate(self.rows))
        return sum(of_directions, np.zeros(())).ravel()

    def modal_tangent(self, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of the modal forces by the modal amplitudes [s^-2] from tangents of points."""
        n = len(self.components)
        if self.modes > _LARGEST_PRODUCTS:
            return self.stuck_stiffness + self._modal_tangent_beyond_stuck(tangent)
        by_direction = self._by_direction(tangent)
        jacobian = np.zeros((self.modes * self.modes, n * n))
        for d, products in enumerate(self._products):
            for e, product in enumerate(products):
                jacobian += product.T @ by_direction[:, d, :, e, :].reshape(-1, n * n)
        by_part = jacobian.reshape(self.modes, self.modes, n, n).transpose(2, 0, 3, 1)
        return by_part.reshape(n * self.modes, n * self.modes)

    def describing_function(
        self, motion: NDArray[np.float64], force: NDArray[np.float64]
    ) -> NDArray[np.complex128]:
        """Describing function D of each point and direction: complex force over displacement.

        With u = Im((s + i c) exp(iwt)) it is (f_s + i f_c) / (s + i c); a point at rest has the
        stiffness of its elements while they stick.

        Returns
        -------
        ndarray
            Shape (points, directions) [N/m].
        """
        u, f = self._first_harmonic(motion), self._first_harmonic(force)
        at_rest = u == 0
        return np.where(at_rest, self._stuck_stiffness_of_points, f / np.where(at_rest, 1.0, u))

    def describing_function_derivative(
        self,
        motion: NDArray[np.float64],
        D: NDArray[np.complex128],
        tangent: NDArray[np.float64],
    ) -> NDArray[np.complex128]:
        """Derivative of each describing function by the motion of its point.

        From D u = f, u and f complex: ``dD = (df - D du) / u``; zero for a point at rest.

        Parameters
        ----------
        motion, tangent
            Motion and tangent of the points, as the law takes and gives them.
        D
            As from ``describing_function``.

        Returns
        -------
        ndarray
            Shape (points, directions, directions, components) [N/m2].
        """
        sin, cos = self.components.sin(), self.components.cos()
        tangent = self._by_direction(tangent)
        change = tangent[:, :, sin] + 1j * tangent[:, :, cos]
        for d in range(len(self.rows)):
            change[:, d, d, sin] -= D[:, d]
            change[:, d, d, cos] -= 1j * D[:, d]
        u = self._first_harmonic(motion)
        at_rest = u == 0
        return np.where(
            at_rest[:, :, None, None], 0.0, change / np.where(at_rest, 1.0, u)[:, :, None, None]
        )

    def spring_stiffness(self, k: NDArray) -> NDArray:
        """Modal stiffness of springs at the points, real or complex, k (points, directions)."""
        if np.iscomplexobj(k):  # products of real matrices take a quarter of the time
            return self.spring_stiffness(k.real) + 1j * self.spring_stiffness(k.imag)
        return sum(B.T @ (springs[:, None] * B) for B, springs in zip(self.rows, k.T, strict=True))

    def spring_force_derivative(
        self, shape: NDArray[np.float64], dk: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Derivative of ``spring_stiffness(k) @ shape`` by the unknown on which k depends.

        Parameters
        ----------
        shape
            Amplitude of the modes, shape (modes,).
        dk
            Derivative of the springs by the motion of their points, shape (points, directions,
            directions, components).

        Returns
        -------
        ndarray
            Shape (modes, components * modes).
        """
        modes, n = self.modes, len(self.components)
        derivative = np.zeros((modes * modes, n))
        for d, products in enumerate(self._products):
            strain = self.rows[d] @ shape
            for e, product in enumerate(products):
                derivative += product.T @ (strain[:, None] * dk[:, d, e])
        return derivative.reshape(modes, modes, n).transpose(0, 2, 1).reshape(modes, n * modes)

    def _first_harmonic(self, motion: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Complex amplitude ``s + i c`` of motions or forces, shape (points, directions)."""
        parts = motion.reshape(len(motion), len(self.rows), len(self.components))
        sin, cos = self.components.sin(), self.components.cos()
        return parts[..., sin] + 1j * parts[..., cos]

    def _by_direction(self, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        d, n = len(self.rows), len(self.components)
        return tangent.reshape(-1, d, n, d, n)

    def _modal_tangent_beyond_stuck(self, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """Modal tangent less that of sticking contact: only points that do not stick have any."""
        n, modes = len(self.components), self.modes
        change = self._by_direction(tangent - self._stuck_tangent)
        jacobian = np.zeros((modes, n * n * modes))
        for d, B in enumerate(self.rows):
            for e, C in enumerate(self.rows):
                _add_products(B, C, change[:, d, :, e, :].reshape(-1, n * n), jacobian)
        by_part = jacobian.reshape(modes, n, n, modes)
        return by_part.transpose(1, 0, 2, 3).reshape(n * modes, n * modes)

    @cached_property
    def _products(self) -> list[list[NDArray[np.float64]]]:
        """Products of two modes of each point, by directions, each (points, modes * modes).

        They project the tangents of all points by one product of matrices.
        """
        return [
            [(B[:, :, None] * C[:, None, :]).reshape(len(B), -1) for C in self.rows]
            for B in self.rows
        ]

    @cached_property
    def _stuck_stiffness_of_points(self) -> NDArray[np.float64]:
        """Of each point and direction [N/m], (points, directions)."""
        return self.contact.law.stuck_stiffness(self.contact.points)

    @cached_property
    def stuck_tangents(self) -> NDArray[np.float64]:
        """Tangents of the points while nothing slips and open elements stay open [N/m].

        Their diagonals, shape (points, directions * components); the rest is zero.
        """
        return np.repeat(self._stuck_stiffness_of_points, len(self.components), axis=1)

    @cached_property
    def _stuck_tangent(self) -> NDArray[np.float64]:
        return self.stuck_tangents[:, :, None] * np.eye(self.stuck_tangents.shape[1])


def _add_products(
    B: NDArray[np.float64],
    C: NDArray[np.float64],
    by_part: NDArray[np.float64],
    jacobian: NDArray[np.float64],
) -> None:
    """Add the tangents of two directions, by pairs of components, where they are not zero."""
    changed = np.flatnonzero(by_part.any(axis=1))
    for first in range(0, changed.size, _POINTS_AT_ONCE):
        at = changed[first : first + _POINTS_AT_ONCE]
        weighted = by_part[at][:, :, None] * C[at][:, None, :]
        jacobian += B[at].T @ weighted.reshape(at.size, -1)
