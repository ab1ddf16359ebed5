"""Do the harmonics balance? Residual and Jacobian of the modal equations of a joint."""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import LazyJacobian

#: with more modes, products of two at every point would take more time to read than to form
_MOST_PRODUCTS = 16

#: points whose tangents go to modes together: what is formed for them stays in the cache
_POINTS_AT_ONCE = 256


@dataclass(frozen=True)
class HarmonicBalance:
    """Harmonic balance of a joint in the linear modes of its structure (eq. 2.9, 2.35).

    With ``x(t) = b + sum_h (s_h sin(hwt) + c_h cos(hwt))`` of the modal coordinates, excitation
    ``F sin(wt)``, ``L = diag(w_r^2)``, loss factor eta, the same at every frequency, and contact
    force f in modal coordinates::

        bias:  L b                            + f_0             = 0
        sin:   (L - (hw)^2) s_h - eta L c_h   + f_sh  - phi_F F = 0   (F only at h = 1)
        cos:   (L - (hw)^2) c_h + eta L s_h   + f_ch            = 0

    The unknown x holds the components the joint's law needs (``sin`` and ``cos``, ``sin3`` of the
    third harmonic, ``bias`` where the force has one), one after another: shape
    (components * modes,) [kg^1/2 m]. The parameter is the frequency w [rad/s]. In a basis V of
    fewer modes, ``q = V x``, the equations are projected onto it.

    Parameters
    ----------
    joint
        The structure and its friction elements.
    loss_factor
        eta, the same for all modes [-].
    excitation_force
        F [N].
    basis
        V, orthonormal combinations of the linear modes, shape (linear modes, modes); the linear
        modes themselves by default.

    Raises
    ------
    ValueError
        If loss factor or force are negative or not finite, or the basis is not of this shape.
    """

    joint: Joint
    loss_factor: float
    excitation_force: float
    basis: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        """Refuse what is no balance."""
        checks.instance("joint", self.joint, Joint)
        checks.number("loss_factor", self.loss_factor, at_least=0)
        checks.number("excitation_force", self.excitation_force, at_least=0)
        if self.basis is not None:
            modes = self.joint.natural_frequency.size
            object.__setattr__(self, "basis", checks.array("basis", self.basis, (modes, "modes")))

    def in_basis(self, basis: NDArray[np.float64]) -> "HarmonicBalance":
        """The same balance in a basis that is known to fit, as iterations update it: unchecked."""
        updated = object.__new__(type(self))
        given = {each.name: getattr(self, each.name) for each in fields(self)}
        vars(updated).update(given, basis=basis)
        return updated

    @cached_property
    def components(self) -> tuple[str, ...]:
        """Harmonic components in the order of the unknown."""
        return self.joint.law.components

    @cached_property
    def stiffness(self) -> NDArray[np.float64]:
        """L, or V^T L V [rad^2/s^2], shape (modes, modes)."""
        return self._projected(np.diag((2 * np.pi * self.joint.natural_frequency) ** 2))

    @cached_property
    def rows(self) -> tuple[NDArray[np.float64], ...]:
        """Relative modes of the contact points in each direction [kg^-1/2], (points, modes)."""
        return tuple(B if self.basis is None else B @ self.basis for B in self.joint.rows)

    @cached_property
    def modal_force(self) -> NDArray[np.float64]:
        """Excitation in modal coordinates [kg^-1/2 N], shape (components * modes,)."""
        mode = self.joint.excitation_mode
        mode = mode if self.basis is None else mode @ self.basis
        force = np.zeros((len(self.components), mode.size))
        force[self.components.index("sin")] = mode * self.excitation_force
        return force.ravel()

    def motion(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Relative motion of the contact points [m], shape (points, directions * components)."""
        if x.shape != self._shape:
            raise ValueError(f"x has shape {x.shape}, expected {self._shape}")
        amplitudes = x.reshape(len(self.components), -1)
        return np.hstack([B @ amplitudes.T for B in self.rows])

    def dynamic_stiffness(self, w: float) -> NDArray[np.float64]:
        """The linear part of the equations at w, shape (components * modes,) * 2."""
        matrix = self._springs_and_losses.copy()
        diagonal = np.einsum("ii->i", matrix)
        diagonal -= (w * self._harmonic) ** 2
        return matrix

    def residual(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """What is left of the equations at x and w, shape of x."""
        force = self._to_modes(self.joint.law.evaluate(self.motion(x)))
        return self.dynamic_stiffness(w) @ x + force - self.modal_force

    def residual_and_jacobian(
        self, x: NDArray[np.float64], w: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual, and what forms its exact derivative by x, from one pass over the elements."""
        return self.with_contact(x, w, *self.joint.law.evaluate_with_tangent(self.motion(x)))

    def with_contact(
        self,
        x: NDArray[np.float64],
        w: float,
        force: NDArray[np.float64],
        tangent: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """The same, from the forces of the points and their tangents as the law gives them."""
        linear = self.dynamic_stiffness(w)
        residual = linear @ x + self._to_modes(force) - self.modal_force
        return residual, lambda: linear + self._tangent_to_modes(tangent)

    def residual_and_change(
        self, x: NDArray[np.float64], w: float, dx: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Residual, and its exact derivative along dx, for which no Jacobian is formed."""
        force, tangent = self.joint.law.evaluate_with_tangent(self.motion(x))
        residual, _ = self.with_contact(x, w, force, tangent)
        change = (tangent @ self.motion(dx)[:, :, None])[:, :, 0]
        return residual, self.dynamic_stiffness(w) @ dx + self._to_modes(change)

    def works(self, x: NDArray[np.float64]) -> tuple[float, float, float]:
        """Work over a period of the excitation, and what structure and contact take [J].

        That of a force f on a displacement q is ``pi sum_h h (f_ch s_h - f_sh c_h)``, from the
        harmonic forces of excitation and contact and from what the losses do at each harmonic. They
        balance where the equations hold in a space that holds q.
        """
        q = x.reshape(len(self.components), -1)
        parts = {parse_component(name): i for i, name in enumerate(self.components)}
        contact = self._to_modes(self.joint.law.evaluate(self.motion(x))).reshape(q.shape)
        excitation = self.modal_force.reshape(q.shape)
        driven, lost, rubbed = 0.0, 0.0, 0.0
        for h in (harmonic for part, harmonic in parts if part == "sin"):
            s, c = parts["sin", h], parts["cos", h]
            driven += h * (excitation[c] @ q[s] - excitation[s] @ q[c])
            rubbed += h * (contact[c] @ q[s] - contact[s] @ q[c])
            strain = q[s] @ self.stiffness @ q[s] + q[c] @ self.stiffness @ q[c]
            lost += h * self.loss_factor * strain
        return np.pi * driven, np.pi * lost, np.pi * rubbed

    def frequency_derivative(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """Derivative of the residual by w, shape of x."""
        return -2.0 * w * self._harmonic**2 * x

    def stuck_solution(self, w: float) -> NDArray[np.float64]:
        """The linear response at w while nothing slips, shape of x."""
        w = checks.number("w", w, at_least=0)
        return np.linalg.solve(self.dynamic_stiffness(w) + self._stuck_to_modes, self.modal_force)

    def secant_stiffness(self, x: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Describing function of each point and direction: complex force over displacement.

        With u = Im((s + i c) exp(iwt)) it is (f_s + i f_c) / (s + i c); a point at rest has the
        stiffness of its elements while they stick.

        Returns
        -------
        ndarray
            Shape (points, directions) [N/m].
        """
        motion = self.motion(x)
        return self.secants(motion, self.joint.law.evaluate(motion))

    def secants(
        self, motion: NDArray[np.float64], force: NDArray[np.float64]
    ) -> NDArray[np.complex128]:
        """The same from the motion of the points and their force."""
        u, f = self._first_harmonic(motion), self._first_harmonic(force)
        at_rest = u == 0
        return np.where(at_rest, self._stuck_stiffness, f / np.where(at_rest, 1.0, u))

    def secant_derivative(
        self,
        motion: NDArray[np.float64],
        secant: NDArray[np.complex128],
        tangent: NDArray[np.float64],
    ) -> NDArray[np.complex128]:
        """Derivative of each describing function by the motion of its point.

        From D u = f, u and f complex: ``dD = (df - D du) / u``; zero for a point at rest.

        Parameters
        ----------
        motion, tangent
            Of the points, as the law takes and gives them.
        secant
            As from ``secants``.

        Returns
        -------
        ndarray
            Shape (points, directions, directions, components) [N/m2].
        """
        sin, cos = self.components.index("sin"), self.components.index("cos")
        tangent = self._by_direction(tangent)
        change = tangent[:, :, sin] + 1j * tangent[:, :, cos]
        for d in range(len(self.rows)):
            change[:, d, d, sin] -= secant[:, d]
            change[:, d, d, cos] -= 1j * secant[:, d]
        u = self._first_harmonic(motion)
        at_rest = u == 0
        return np.where(
            at_rest[:, :, None, None], 0.0, change / np.where(at_rest, 1.0, u)[:, :, None, None]
        )

    def stiffness_with(self, secant: NDArray) -> NDArray:
        """L with springs at the points, real or complex, shape (points, directions) [N/m]."""
        springs = (B.T @ (k[:, None] * B) for B, k in zip(self.rows, secant.T, strict=True))
        return self.stiffness + sum(springs)

    def weighted_products(
        self, shape: NDArray[np.float64], weight: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Modal forces of springs that a shape strains, by the motion that changes them.

        Parameters
        ----------
        shape
            Amplitude of the modes, shape (modes,).
        weight
            Derivative of the springs by the motion of their points, shape (points, directions,
            directions, components).

        Returns
        -------
        ndarray
            Shape (modes, components * modes).
        """
        modes, n = len(self.stiffness), len(self.components)
        found = np.zeros((modes * modes, n))
        for d, products in enumerate(self._products):
            strain = self.rows[d] @ shape
            for e, product in enumerate(products):
                found += product.T @ (strain[:, None] * weight[:, d, e])
        return found.reshape(modes, modes, n).transpose(0, 2, 1).reshape(modes, n * modes)

    def _first_harmonic(self, motion: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Complex amplitude ``s + i c`` of motions or forces, shape (points, directions)."""
        parts = motion.reshape(len(motion), len(self.rows), len(self.components))
        sin, cos = self.components.index("sin"), self.components.index("cos")
        return parts[..., sin] + 1j * parts[..., cos]

    def _by_direction(self, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        d, n = len(self.rows), len(self.components)
        return tangent.reshape(-1, d, n, d, n)

    @cached_property
    def _shape(self) -> tuple[int]:
        """Of the unknown."""
        return (len(self.components) * self.rows[0].shape[1],)

    @cached_property
    def _harmonic(self) -> NDArray[np.float64]:
        """Harmonic number of every entry of the unknown."""
        numbers = [harmonic for _, harmonic in map(parse_component, self.components)]
        return np.repeat(np.array(numbers, dtype=float), len(self.stiffness))

    @cached_property
    def _springs_and_losses(self) -> NDArray[np.float64]:
        """The linear part of the equations without inertia."""
        n, modes = len(self.components), len(self.stiffness)
        matrix = np.zeros((n, modes, n, modes))
        parts = {parse_component(name): i for i, name in enumerate(self.components)}
        for (part, harmonic), i in parts.items():
            matrix[i, :, i, :] = self.stiffness
            if part == "sin":
                cos = parts["cos", harmonic]
                matrix[i, :, cos, :] = -self.loss_factor * self.stiffness
                matrix[cos, :, i, :] = self.loss_factor * self.stiffness
        return matrix.reshape(n * modes, n * modes)

    @cached_property
    def _products(self) -> list[list[NDArray[np.float64]]]:
        """Products of two modes of each point, by directions, each (points, modes * modes).

        They take the tangents of the points to modes by one product of matrices.
        """
        return [
            [(B[:, :, None] * C[:, None, :]).reshape(len(B), -1) for C in self.rows]
            for B in self.rows
        ]

    def _projected(self, matrix: NDArray[np.float64]) -> NDArray[np.float64]:
        return matrix if self.basis is None else self.basis.T @ matrix @ self.basis

    def _to_modes(self, force: NDArray[np.float64]) -> NDArray[np.float64]:
        n = len(self.components)
        modal = sum(force[:, d * n : (d + 1) * n].T @ B for d, B in enumerate(self.rows))
        return modal.ravel()

    def _tangent_to_modes(self, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """Tangents of the points as the derivative of modal forces by modal amplitudes."""
        n, modes = len(self.components), len(self.stiffness)
        if modes > _MOST_PRODUCTS:
            return self._stuck_to_modes + self._changed_to_modes(tangent)
        by_direction = self._by_direction(tangent)
        jacobian = np.zeros((modes * modes, n * n))
        for d, products in enumerate(self._products):
            for e, product in enumerate(products):
                jacobian += product.T @ by_direction[:, d, :, e, :].reshape(-1, n * n)
        by_part = jacobian.reshape(modes, modes, n, n).transpose(2, 0, 3, 1)
        return by_part.reshape(n * modes, n * modes)

    def _changed_to_modes(self, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same less what the points have while they stick: of the others alone."""
        n, modes = len(self.components), len(self.stiffness)
        change = self._by_direction(tangent - self._stuck_tangent)
        jacobian = np.zeros((modes, n * n * modes))
        for d, B in enumerate(self.rows):
            for e, C in enumerate(self.rows):
                by_part = change[:, d, :, e, :].reshape(-1, n * n)
                changed = np.flatnonzero(by_part.any(axis=1))
                for first in range(0, changed.size, _POINTS_AT_ONCE):
                    at = changed[first : first + _POINTS_AT_ONCE]
                    moved = by_part[at][:, :, None] * C[at][:, None, :]
                    jacobian += B[at].T @ moved.reshape(at.size, -1)
        jacobian = jacobian.reshape(modes, n, n, modes)
        return jacobian.transpose(1, 0, 2, 3).reshape(n * modes, n * modes)

    @cached_property
    def _stuck_stiffness(self) -> NDArray[np.float64]:
        """Of the points in each direction [N/m]."""
        return self.joint.law.stuck_stiffness(self.joint.points)

    @cached_property
    def _stuck_tangent(self) -> NDArray[np.float64]:
        """Tangents of the points while nothing slips and open elements stay open."""
        each = np.repeat(self._stuck_stiffness, len(self.components), axis=1)
        return each[:, :, None] * np.eye(each.shape[1])

    @cached_property
    def _stuck_to_modes(self) -> NDArray[np.float64]:
        stuck = self._projected(self.joint.stuck_stiffness())
        return np.kron(np.eye(len(self.components)), stuck)


def parse_component(name: str) -> tuple[str, int]:
    """Which coefficient a harmonic component is, and of which harmonic.

    >>> parse_component("cos3"), parse_component("sin"), parse_component("bias")
    (("cos", 3), ("sin", 1), ("bias", 0))
    """
    part = name.rstrip("0123456789")
    if part == "bias":
        return part, 0
    return part, int(name.removeprefix(part) or 1)
