"""Nonlinear modes by the extended periodic motion concept (EPMC), with any number of harmonics.

An artificial negative damping that balances friction and structural damping keeps the joint in a
periodic motion without excitation. Where a law has a compiled kernel, ``compiled_epmc`` has these
equations too.

References
----------
M. Krack: Nonlinear modal analysis of nonconservative systems: extension of the periodic motion
concept. Computers and Structures 154 (2015) 59-71.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.harmonics import Components
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import Equations, LazyJacobian
from boltjoint.solvers.newton import solve

#: maximum iterations for the frequency of an amplitude, and tolerance of its relative change
_ITERATIONS, _TOLERANCE = 20, 1e-14

#: a backbone begins and ends at these shares of the amplitudes it has to cover, which are those of
#: the stuck mode and of one whose points move in phase
_FIRST_SHARE, _LAST_SHARE = 0.3, 1.5

#: loss factor in whose place a smaller one counts, so that amplitudes stay finite: rounding is some
#: millionth of it
_LEAST_LOSS_FACTOR = 1e-10

#: that of a structure that does not dissipate: where its backbone ends
_WITHOUT_DISSIPATION = 1e-5


class _Unexcited(NamedTuple):
    """The balance without excitation and inertia at a motion x of a frequency w [rad/s].

    Its residual and Jacobian.
    """

    x: NDArray[np.float64]
    w: float
    residual: NDArray[np.float64]
    jacobian: LazyJacobian


class EPMCEquations(Equations):
    """Equations of the nonlinear mode phi and its eigenvalue lambda at a modal amplitude a.

    With ``f(q)`` the contact's harmonic forces under ``q = a beta + Im(a sum_h phi_h exp(ihwt))``,
    bias ``a beta`` where the law has one, L, H and the components as of ``HarmonicBalance``::

        (L + i H(hw) - h^2 w^2 - 2 i h zeta w^2) phi_h + f_h(q) / a = 0
        L beta + f_0(q) / a = 0
        phi^H phi = 1,  Im(phi^T phi) = 0      (phi: that of the first harmonic)

    ``lambda = w^2 (1 + 2 i zeta)`` holds the frequency w and the damping ratio zeta. The first
    harmonic is normalised to unit modal mass with the conjugate (Krack 2015); its phase, which is
    arbitrary, makes ``phi^T phi`` real. The unknown is that of the balance over a, then real and
    imaginary part of lambda over that of the stuck mode; the parameter is the logarithm of a.

    Parameters
    ----------
    joint
        The structure and its friction elements.
    damping
        Damping of the structure; a number is a loss factor.
    resonance
        Number of the stuck mode at which the backbone starts, from 1.

    Raises
    ------
    ValueError
        If the structure has fewer modes.
    """

    residual_scale = 1.0

    def __init__(self, joint: Joint, damping: Damping | float, resonance: int = 1) -> None:
        self.balance = HarmonicBalance(joint, damping, 0.0)
        modes = len(self.balance.stiffness)
        #: where the first harmonic is in the unknown
        self.sin, self.cos = (
            slice(first * modes, (first + 1) * modes)
            for first in (self.components.sin(), self.components.cos())
        )
        _, self._harmonic, self._power, self._varying = self.balance.linear_part()
        #: moves what stands in the component of a sine to that of its cosine, and back
        later, sign = self.components.quarter_later()
        self._turned = (modes * later[:, None] + np.arange(modes)).ravel()
        self._sign = np.repeat(sign, modes)
        self.resonance, place = joint.check_resonance(resonance), joint.place_of(resonance)
        squared, vectors = np.linalg.eigh(self.balance.stiffness + joint.stuck_stiffness())
        self.scale, self.stuck = squared[place], vectors[:, place]
        #: imaginary part of the stuck lambda over its real part: it limits the response
        at_rest = np.zeros_like(self.stuck)
        loss = self.balance.damping_matrix.work(np.sqrt(self.scale), self.stuck, at_rest)
        dissipates = self.balance.damping_matrix.dissipates
        least = _LEAST_LOSS_FACTOR if dissipates else _WITHOUT_DISSIPATION
        self.loss = max(loss / self.scale, least)
        self._last: _Unexcited | None = None

    def with_balance(self, balance: HarmonicBalance) -> "EPMCEquations":
        """The same equations, in the same scale, of another balance.

        It is without excitation, and of as many modes and harmonics.
        """
        other = copy(self)
        other.balance, other._last = balance, None
        _, _, other._power, other._varying = balance.linear_part()
        return other

    @property
    def components(self) -> Components:
        """Harmonic components in the order of the unknown."""
        return self.balance.components

    def start(self) -> NDArray[np.float64]:
        """The stuck mode and its eigenvalue, without damping."""
        mode = np.zeros(self._harmonic.size)
        mode[self.sin] = self.stuck
        return np.append(mode, [1.0, 0.0])

    def damped_start(self) -> NDArray[np.float64]:
        """The stuck mode with its damping and its eigenvalue: those nearest to ``start``.

        Where modes lie as close as they are damped, they are far from real.
        """
        stiffness = self.balance.complex_stiffness(np.sqrt(self.scale))
        squared, vectors = np.linalg.eig(stiffness + self.balance.joint.stuck_stiffness())
        nearest = np.argmax(abs(self.stuck @ vectors) / np.linalg.norm(vectors, axis=0))
        phi = vectors[:, nearest] / np.linalg.norm(vectors[:, nearest])
        phi = phi * np.exp(-0.5j * np.angle(phi @ phi))
        start = self.start()
        start[self.sin], start[self.cos] = phi.real, phi.imag
        start[-2:] = squared[nearest].real / self.scale, squared[nearest].imag / self.scale
        return start

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and Jacobian at the modal amplitude exp(p)."""
        a, mode = np.exp(p), x[:-2]
        s, c = mode[self.sin], mode[self.cos]
        unexcited = self._unexcited(a * mode, self._frequency(x[-2]))
        residual = np.append(unexcited.residual / (a * self.scale), [s @ s + c @ c - 1, s @ c])
        residual[:-2] -= x[-2] * self._harmonic**2 * mode + x[-1] * self._quarter_later(mode)
        if self._power.size:
            residual[:-2] += self._varying_damping(x[-2]) @ mode
        return residual, lambda: self._jacobian(x, a, unexcited.jacobian())

    def residuals(self, unknowns: NDArray[np.float64]) -> NDArray[np.float64]:
        """Residuals at several motions, (motions, unknowns).

        Each row of theirs is an unknown and ln(amplitude), (motions, unknowns + 1).
        """
        return np.array([self.evaluate(y[:-1], y[-1])[0] for y in unknowns])

    def _unexcited(self, x: NDArray[np.float64], w: float) -> _Unexcited:
        """The balance at x, kept for the derivative by the parameter that follows the residual."""
        last = self._last
        if last is None or w != last.w or not np.array_equal(x, last.x):
            residual, jacobian = self.balance.residual_and_jacobian(x, 0.0, w)
            last = self._last = _Unexcited(x, w, residual, cache(jacobian))
        return last

    def _quarter_later(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The harmonics h of x a quarter of their period later, times h: i h phi_h."""
        return self._sign * self._harmonic * x[self._turned]

    def _frequency(self, real: float) -> float:
        """Frequency w by the real part of lambda, which may be negative in an iteration [rad/s]."""
        return float(np.sqrt(abs(real) * self.scale))

    def _varying_damping(self, real: float) -> NDArray[np.float64]:
        """The part of the damping that depends on the frequency, over the scale."""
        return np.tensordot(self._frequency(real) ** self._power, self._varying, 1) / self.scale

    def _jacobian(
        self, x: NDArray[np.float64], a: float, force_jacobian: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """The Jacobian from that of the balance without excitation and inertia at an amplitude."""
        mode, (real, imaginary) = x[:-2], x[-2:]
        n, harmonic = mode.size, self._harmonic
        jacobian = np.zeros((x.size, x.size))
        jacobian[:n, :n] = force_jacobian / self.scale
        entries = np.arange(n)
        jacobian[entries, entries] -= real * harmonic**2
        jacobian[entries, self._turned] -= imaginary * self._sign * harmonic
        jacobian[:n, n] = -(harmonic**2) * mode
        jacobian[:n, n + 1] = -self._quarter_later(mode)
        if self._power.size:
            w = self._frequency(real)
            jacobian[:n, :n] += self._varying_damping(real)
            # by the real part of lambda, on which w depends
            change = np.tensordot(self._power * w ** (self._power - 1), self._varying, 1)
            jacobian[:n, n] += np.sign(real) / (2 * w) * (change @ mode)
        w = self._frequency(real)
        of_contact = self.balance.contact.frequency_derivative(a * mode, w)
        if of_contact is not None:
            jacobian[:n, n] += np.sign(real) / (2 * w) * of_contact / a
        s, c = mode[self.sin], mode[self.cos]
        jacobian[n, self.sin], jacobian[n, self.cos] = 2 * s, 2 * c
        jacobian[n + 1, self.sin], jacobian[n + 1, self.cos] = c, s
        return jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the logarithm of the modal amplitude."""
        a, mode = np.exp(p), x[:-2]
        unexcited = self._unexcited(a * mode, self._frequency(x[-2]))
        change = unexcited.jacobian() @ mode
        return np.append((change - unexcited.residual / a) / self.scale, [0.0, 0.0])

    def amplitudes_for(
        self, forces: Sequence[float], window: tuple[float, float]
    ) -> tuple[float, float]:
        """Range of modal amplitudes of the responses to forces in a window [kg^1/2 m].

        From below that of the stuck mode under the smallest force at the ends of the window [Hz] to
        above that which structural damping alone allows under the largest force. In full slip
        nothing else limits the response: without structural damping, a loss factor of 1e-5 does,
        and motions that the structure does not damp count as damped by one of 1e-10.
        Damping that grows with the frequency counts as at the lower end of the window.
        """
        forces, window = checks.levels("forces", forces), checks.interval("window", window)
        excitation = self.balance.joint.excitation.modes
        distance = max(abs(self.scale - (2 * np.pi * f) ** 2) for f in window)
        lowest = min(forces) * abs(self.stuck @ excitation) / distance
        H = self.balance.damping_matrix.at(2 * np.pi * window[0])
        stiffness = self.balance.stiffness
        # rigid-body modes have no stiffness, and no resonance below the window
        inertia = (2 * np.pi * window[0]) ** 2 * np.eye(len(stiffness))
        H = H + _LEAST_LOSS_FACTOR * (stiffness + inertia)
        if not self.balance.damping_matrix.dissipates:
            H = H + _WITHOUT_DISSIPATION * stiffness
        # |phi^T e| / phi^H H phi where phi^H phi = 1, by Cauchy and Schwarz
        compliance = (excitation.conj() @ np.linalg.solve(H, excitation)).real
        highest = max(forces) * np.sqrt(compliance / np.linalg.eigvalsh(H)[0])
        return _FIRST_SHARE * lowest, _LAST_SHARE * highest


@dataclass(frozen=True, eq=False)
class ModalState:
    """The nonlinear mode of a joint at one modal amplitude.

    Parameters
    ----------
    equations
        Equations of the mode.
    unknown
        Solution of the equations.
    log_amplitude
        Logarithm of the modal amplitude a [kg^1/2 m].
    """

    equations: EPMCEquations
    unknown: NDArray[np.float64]
    log_amplitude: float

    @property
    def amplitude(self) -> float:
        """Modal amplitude a [kg^1/2 m]."""
        return float(np.exp(self.log_amplitude))

    @cached_property
    def mode(self) -> NDArray[np.complex128]:
        """Mode phi of the first harmonic, phi^H phi = 1, shape (linear modes,)."""
        return self.unknown[self.equations.sin] + 1j * self.unknown[self.equations.cos]

    @property
    def modal_coordinate(self) -> NDArray[np.float64]:
        """The motion [kg^1/2 m], shape (components, linear modes)."""
        return self.amplitude * self.unknown[:-2].reshape(len(self.equations.components), -1)

    @property
    def eigenvalue(self) -> complex:
        """Eigenvalue lambda [rad2/s2]."""
        return complex(*self.unknown[-2:]) * self.equations.scale

    @property
    def frequency(self) -> float:
        """Natural frequency [Hz]; 0 where an interpolation has a negative eigenvalue."""
        return float(np.sqrt(max(self.eigenvalue.real, 0.0)) / (2 * np.pi))

    @property
    def damping_ratio(self) -> float:
        """Modal damping ratio zeta [-]."""
        return self.eigenvalue.imag / (2 * self.eigenvalue.real)

    @property
    def curves(self) -> NDArray[np.float64]:
        """Natural frequency [Hz] and modal damping ratio, as drawn over the amplitude."""
        return np.array([self.frequency, self.damping_ratio])

    def excited_distance(self, excitation: NDArray) -> float:
        """Distance ``|lambda - w^2|`` at which an excitation causes the amplitude [rad2/s2]."""
        return abs(self.mode @ excitation / (self.mode @ self.mode)) / self.amplitude

    def frequencies_under(self, excitation: NDArray) -> tuple[float, float]:
        """Squares of the frequencies at which an excitation causes the amplitude [rad2/s2].

        Below and above that of the peak; that itself where the excitation does not suffice.
        """
        distance = self.excited_distance(excitation)
        return self._at_distance(distance, -1)[0], self._at_distance(distance, 1)[0]

    @cached_property
    def squared_at_peak(self) -> float:
        """Square of the frequency at which the least excitation causes the amplitude [rad2/s2]."""
        return self._at_distance(0.0, 0)[0]

    @cached_property
    def least_distance(self) -> float:
        """Least distance ``|lambda - w^2|`` of any frequency, that at the peak [rad2/s2]."""
        return self._at_distance(0.0, 0)[1]

    def under_excitation(self, squared: float) -> tuple[complex, complex]:
        """Eigenvalue at the square of a frequency, and its derivative by that square.

        The damping of the structure is that at the excitation frequency, not at w::

            lambda + i phi^T (H(frequency) - H(w)) phi / (phi^T phi)
        """
        varying = self.equations.balance.damping_matrix.varying
        if varying is None:
            return self.eigenvalue, 0.0
        w, own = np.sqrt(max(squared, 0.0)), np.sqrt(self.eigenvalue.real)
        phi = self.mode / np.sqrt(self.mode @ self.mode)
        change = phi @ (varying.at(w) - varying.at(own)) @ phi
        slope = phi @ varying.derivative.at(w) @ phi / (2 * w) if w > 0 else 0.0
        return complex(self.eigenvalue + 1j * change), complex(1j * slope)

    def _at_distance(self, distance: float, side: int) -> tuple[float, float]:
        """Square of the frequency at a distance from lambda, and the least distance of any.

        Below the nearest frequency with side -1, above with 1; the nearest itself with 0.
        """
        squared = self.eigenvalue.real
        for _ in range(_ITERATIONS):
            # linear in the square x of the frequency: lambda(x) - x = start + growth x
            eigenvalue, slope = self.under_excitation(squared)
            start, growth = eigenvalue - slope * squared, slope - 1.0
            size, product = abs(growth) ** 2, start.conjugate() * growth
            centre, nearest = -product.real / size, product.imag / size
            before = squared
            squared = centre + side * np.sqrt(max(distance**2 / size - nearest**2, 0.0))
            if slope == 0 or abs(squared - before) <= _TOLERANCE * abs(squared):
                break
        return float(squared), float(nearest * abs(growth))

    @cached_property
    def slope(self) -> NDArray[np.float64] | None:
        """Derivative of the unknown by the logarithm of the amplitude; None at a turning point."""
        jacobian = self.equations.evaluate(self.unknown, self.log_amplitude)[1]()
        change = self.equations.parameter_derivative(self.unknown, self.log_amplitude)
        return solve(jacobian, -change)

    @cached_property
    def contact_stiffness(self) -> NDArray[np.complex128]:
        """Modal describing function of the contact [s^-2], shape (linear modes,) * 2."""
        balance = self.equations.balance
        w = np.sqrt(max(self.eigenvalue.real, 0.0))
        springs = balance.describing_function(self.amplitude * self.unknown[:-2], w)
        return balance.contact.spring_stiffness(springs)
