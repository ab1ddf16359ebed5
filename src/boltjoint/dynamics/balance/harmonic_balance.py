"""Harmonic balance of a structure with a joint in modal coordinates, and its output point.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: eq. 2.9 and 2.35.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, DampingMatrix, ModalStructure, Term, as_damping
from boltjoint.dynamics.balance.modal_contact import ModalContact
from boltjoint.harmonics import Components
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import Derivative, LazyJacobian

#: a matrix or a number, and one of each harmonic
Number = NDArray[np.float64] | float
_ByHarmonic = Callable[[int], Number]


@dataclass(frozen=True)
class HarmonicBalance:
    """Harmonic balance of a joint in the linear modes of its structure (thesis, eq. 2.9 and 2.35).

    With ``x(t) = b + sum_h (s_h sin(hwt) + c_h cos(hwt))`` of the modal coordinates, excitation
    ``F sin(wt)``, ``L = diag(w_r^2)``, damping H(hw) of the harmonic h (``eta L`` with a loss
    factor eta) and contact force f in modal coordinates::

        bias:  L b                          + f_0             = 0
        sin:   (L - (hw)^2) s_h - H(hw) c_h + f_sh  - phi_F F = 0   (F only at h = 1)
        cos:   (L - (hw)^2) c_h + H(hw) s_h + f_ch            = 0

    Excitation whose points are not in phase has a part ``F cos(wt)`` too, with its own phi_F. The
    unknown x holds the components of the law (``sin``, ``cos``, ``sin3`` of the third harmonic,
    ``bias`` of a mean), one after another: shape (components * modes,) [kg^1/2 m]. The parameter is
    w [rad/s]. In a basis V of fewer modes, ``q = V x``, the equations are projected onto it.

    Parameters
    ----------
    joint
        The structure and its friction elements.
    damping
        Damping of the structure; a number is a loss factor.
    excitation_force
        F [N], or the acceleration of the supports [m/s2].
    basis
        V, orthonormal combinations of the linear modes, (linear modes, modes); these by default.
    inertial
        Modes (of the basis), from the first, with inertia in harmonics above the first; all by
        default.

    Raises
    ------
    ValueError
        If damping or force are negative or not finite, or the basis is of another shape.
    """

    joint: Joint
    damping: Damping | float
    excitation_force: float
    basis: NDArray[np.float64] | None = None
    inertial: int | None = None

    def __post_init__(self) -> None:
        """Refuse parameters that are out of range."""
        checks.instance("joint", self.joint, Joint)
        object.__setattr__(self, "damping", as_damping(self.damping))
        checks.number("excitation_force", self.excitation_force, at_least=0)
        if self.basis is not None:
            modes = self.joint.natural_frequency.size
            object.__setattr__(self, "basis", checks.array("basis", self.basis, (modes, "modes")))
        if self.inertial is not None:
            checks.whole("inertial", self.inertial, at_least=0)

    def in_basis(self, basis: NDArray[np.float64]) -> "HarmonicBalance":
        """The same balance in another basis of the right shape, which is not checked."""
        updated = object.__new__(type(self))
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        vars(updated).update(values, basis=basis)
        return updated

    @cached_property
    def components(self) -> Components:
        """Harmonic components in the order of the unknown."""
        return Components(self.joint.law.components)

    @cached_property
    def stiffness(self) -> NDArray[np.float64]:
        """L, or V^T L V [rad^2/s^2], shape (modes, modes)."""
        return self._structure.stiffness

    @cached_property
    def stiffness_of_mean(self) -> NDArray[np.float64]:
        """L of the bias: the mean of rigid-body motion is zero, though any would do."""
        return self.stiffness + self._structure.stiffness_to_hold(self.joint.is_rigid)

    @cached_property
    def damping_matrix(self) -> DampingMatrix:
        """H(w) [rad^2/s^2], shape (modes, modes)."""
        return as_damping(self.damping).matrix(self._structure)

    def complex_stiffness(self, w: float, harmonic: int = 1) -> NDArray[np.complex128]:
        """``L + i H(hw)`` of the harmonic h [rad^2/s^2], shape (modes, modes)."""
        if self.damping_matrix.varying is None and harmonic == 1:
            return self._constant_complex_stiffness
        damping = self._damping(self.damping_matrix, harmonic, w)
        return np.asarray(self.stiffness + 1j * damping, complex)

    @cached_property
    def contact(self) -> ModalContact:
        """The friction elements in the same coordinates."""
        return ModalContact(self.joint.contact, self.basis)

    @cached_property
    def modal_force(self) -> NDArray[np.float64]:
        """Excitation in modal coordinates [kg^-1/2 N], shape (components * modes,)."""
        mode = self.joint.excitation.modes
        mode = mode if self.basis is None else mode @ self.basis
        force = np.zeros((len(self.components), mode.size))
        force[self.components.sin()] = mode.real * self.excitation_force
        force[self.components.cos()] = mode.imag * self.excitation_force
        return force.ravel()

    def motion(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Relative motion of the contact points [m], shape (points, directions * components)."""
        return self.contact.motion(x)

    def dynamic_stiffness(self, w: float) -> NDArray[np.float64]:
        """The linear part of the equations at w, shape (components * modes,) * 2."""
        return self._add_linear_part(np.zeros_like(self._static_stiffness), w)

    def linear_force(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """``dynamic_stiffness(w) @ x``, harmonic by harmonic."""
        stiffness = (self.components.rows(x) @ self.stiffness).ravel()
        if self._mean is not None:
            stiffness[self._mean] = self.stiffness_of_mean @ x[self._mean]
        return stiffness - (w * self._harmonic) ** 2 * x + self.damping_force(x, w)

    def damping_force(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """Force of the damping of the structure at w, shape of x."""
        factor, frequency = self._damping_of(self._number, w)
        return (factor * self.damping_matrix.along(self.components.later(x), frequency)).ravel()

    def residual(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """Residual of the equations at x and w, shape of x."""
        return self.contact.force(x, w) + self.linear_force(x, w) - self.modal_force

    def residual_and_jacobian(
        self, x: NDArray[np.float64], w: float, w_of_contact: float | None = None
    ) -> tuple[NDArray[np.float64], Derivative]:
        """Residual and its lazily evaluated Jacobian, from one pass over the friction elements.

        The contact may have a frequency of its own, ``w_of_contact`` [rad/s]: that of a mode whose
        inertia is put apart.
        """
        at = w if w_of_contact is None else w_of_contact
        force, tangent = self.contact.force_and_tangent(x, at)
        residual = self.linear_force(x, w) + force - self.modal_force
        return residual, Derivative(
            lambda precision: self._add_linear_part(tangent(precision), w),
            lambda dx: self.linear_force(dx, w) + tangent.along(dx),
        )

    def assemble(
        self,
        x: NDArray[np.float64],
        w: float,
        force: NDArray[np.float64],
        tangent: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and Jacobian from the forces of the points and their tangents by the law."""
        linear = self.dynamic_stiffness(w)
        residual = linear @ x + self.contact.modal_force(force) - self.modal_force
        return residual, lambda: linear + self.contact.modal_tangent(tangent)

    def change(
        self, dx: NDArray[np.float64], w: float, tangent: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Derivative of the residual along dx from the tangents of the points by the law."""
        return self.linear_force(dx, w) + self.contact.change(dx, tangent)

    def frequency_derivative(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """Derivative of the residual by w, shape of x."""
        derivative = -2.0 * w * self._harmonic**2 * x
        varying = self.damping_matrix.varying
        if varying is not None:
            # either the factor or the frequency is the number of the harmonic, the other 1 or w
            rate, (_, frequency) = varying.derivative, self._damping_of(self._number, w)
            derivative += (self._number * rate.along(self.components.later(x), frequency)).ravel()
        of_contact = self.contact.frequency_derivative(x, w)
        return derivative if of_contact is None else derivative + of_contact

    def stuck_solution(self, w: float) -> NDArray[np.float64]:
        """The linear response at w while nothing slips, shape of x."""
        w = checks.number("w", w, at_least=0)
        stiffness = self.dynamic_stiffness(w) + self.contact.stuck_stiffness
        return np.asarray(np.linalg.solve(stiffness, self.modal_force), float)

    def describing_function(self, x: NDArray[np.float64], w: float) -> NDArray[np.complex128]:
        """Describing function of each point and direction at x and w [N/m] (``ModalContact``)."""
        motion = self.motion(x)
        return self.contact.describing_function(motion, self.joint.law.evaluate(motion, w))

    def linear_part(self) -> tuple[NDArray[np.float64], ...]:
        """What ``dynamic_stiffness`` is made of.

        Returns
        -------
        tuple
            The matrix at zero frequency; harmonic number of every entry, as inertia has it; powers
            of the frequency w of further terms, and their matrices, shape (terms, n, n).
        """
        terms = () if self.damping_matrix.varying is None else self.damping_matrix.varying.terms
        varying = np.zeros((len(terms), *self._static_stiffness.shape))
        for matrix, term in zip(varying, terms, strict=True):
            _add_damping(matrix, self.components, _by_harmonic(term))
        power = np.array([term.power for term in terms], dtype=float)
        return self._static_stiffness, self._harmonic, power, varying

    @cached_property
    def _mean(self) -> slice | None:
        """Where in the unknown the bias of rigid-body modes is; None without one."""
        is_needed = self.components.has_bias and self.joint.is_rigid.any()
        return slice(len(self.stiffness)) if is_needed else None

    @cached_property
    def _harmonic(self) -> NDArray[np.float64]:
        """Harmonic number of every entry of the unknown, as its inertia has it."""
        return _harmonic_of_inertia(self.components, len(self.stiffness), self.inertial)

    @cached_property
    def _structure(self) -> ModalStructure:
        """The structure in the coordinates of the balance."""
        return self.joint.structure(self.basis)

    @cached_property
    def _constant_complex_stiffness(self) -> NDArray[np.complex128]:
        return np.asarray(self.stiffness + 1j * self.damping_matrix.constant.at(0.0), complex)

    @cached_property
    def _static_stiffness(self) -> NDArray[np.float64]:
        """Elasticity and constant damping: the linear part of the equations at zero frequency."""
        matrix = self.components.of_each(self.stiffness)
        if self._mean is not None:
            matrix[self._mean, self._mean] = self.stiffness_of_mean
        constant = self.damping_matrix.constant
        _add_damping(matrix, self.components, lambda h: self._damping(constant, h, 0.0))
        return matrix

    def _add_linear_part(self, matrix: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """A matrix with the linear part of the equations at w added, in place: it may be large."""
        matrix += self._static_stiffness
        np.einsum("ii->i", matrix)[:] -= (w * self._harmonic) ** 2
        if (varying := self.damping_matrix.varying) is not None:
            _add_damping(matrix, self.components, lambda h: self._damping(varying, h, w))
        return matrix

    @cached_property
    def _number(self) -> NDArray[np.float64]:
        """Number of the harmonic of each component; 1 of the bias, which nothing damps."""
        return np.maximum(self.components.number, 1.0)[:, None]

    def _damping(self, matrix: DampingMatrix, harmonic: int, w: float) -> Number:
        """H of a harmonic [rad^2/s^2]."""
        factor, frequency = self._damping_of(harmonic, w)
        return factor * matrix.at(float(frequency))

    def _damping_of(self, harmonic: Number, w: float) -> tuple[Number, Number]:
        """Factor and frequency [rad/s] of ``factor H(frequency)``, the damping of harmonics."""
        return 1.0, harmonic * w


def _harmonic_of_inertia(
    components: Components, modes: int, inertial: int | None
) -> NDArray[np.float64]:
    """Harmonic number of every entry of the unknown, 0 without inertia, (components * modes,)."""
    number = components.number.astype(float)
    harmonic = np.repeat(number[:, None], modes, axis=1)
    if inertial is not None:
        harmonic[number > 1, inertial:] = 0.0
    return harmonic.ravel()


def _add_damping(matrix: NDArray[np.float64], components: Components, damping: _ByHarmonic) -> None:
    """Add the H of each harmonic to the linear part of the equations."""
    count = len(components)
    blocks = matrix.reshape((count, len(matrix) // count) * 2)
    for harmonic, sin, cos in components.harmonics:
        H = damping(harmonic)
        blocks[sin, :, cos, :] -= H
        blocks[cos, :, sin, :] += H


def _by_harmonic(term: Term) -> _ByHarmonic:
    """A term of H of the harmonic h, less the power of the frequency."""
    return lambda h: h**term.power * term.factor * term.matrix


def stiffness_of_harmonic(
    jacobian: NDArray[np.float64], components: Components, harmonic: int
) -> NDArray[np.complex128]:
    """Complex stiffness of the harmonic h in a Jacobian, of small motion at h times w alone.

    With ``q = s + i c`` the force ``D q`` has equal diagonal blocks Re D, and Im D and -Im D beside
    them; what couples q with its conjugate is left out. Shape (modes, modes).
    """
    count = len(components)
    blocks = jacobian.reshape(count, len(jacobian) // count, count, -1)
    s, c = components.sin(harmonic), components.cos(harmonic)
    real = blocks[s, :, s] + blocks[c, :, c]
    return np.asarray((real + 1j * (blocks[c, :, s] - blocks[s, :, c])) / 2, complex)


class OutputPoint:
    """Complex first-harmonic amplitude of the output point [m] from modal coordinates.

    Parameters
    ----------
    balance
        The modal equations, in linear modes.
    """

    def __init__(self, balance: HarmonicBalance) -> None:
        self._mode = balance.joint.sensors.output
        self._sin, self._cos = balance.components.sin(), balance.components.cos()

    def __call__(self, q: NDArray[np.float64]) -> complex:
        """Complex amplitude, sine coefficient + i cosine coefficient [m]."""
        amplitude = q.reshape(-1, self._mode.size) @ self._mode
        return complex(amplitude[self._sin], amplitude[self._cos])

    def value(self, q: NDArray[np.float64]) -> float:
        """Amplitude [m]."""
        return abs(self(q))

    def amplitudes(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Amplitudes [m] of several solutions, shape (solutions, components * modes)."""
        if not len(q):
            return np.zeros(0)
        at = q.reshape(len(q), -1, self._mode.size) @ self._mode
        return np.hypot(at[:, self._sin], at[:, self._cos])

    def slope(self, q: NDArray[np.float64], dq: NDArray[np.float64]) -> float:
        """Half the derivative of the square of the amplitude, of the same sign as its own."""
        return float((self(q).conjugate() * self(dq)).real)
