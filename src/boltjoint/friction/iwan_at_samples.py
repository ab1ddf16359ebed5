"""Hysteresis of Iwan elements at the samples of a period, by Masing's rule with a memory.

From a reversal of the motion at (u_r, f_r) the force follows the curve F of first loading, twice as
large, ``f = f_r +- 2 F(|u - u_r| / 2)``, until it meets the branch that was left at the reversal
before, and follows that one again (Masing 1926). The largest displacement of a period lies on the
curve of first loading itself: from there on a single period is the steady state. At the samples
this is exact for the whole distribution; between them the motion is taken as straight.

The force at a reversal is that of a sample, so that changes follow branches as forces do,
``df = df_r + F'(|u - u_r| / 2) (du - du_r)``. They are summed along the period, or, for derivatives
by all displacements at once, against it.

References
----------
G. Masing: Eigenspannungen und Verfestigung beim Messing. Proceedings of the Second International
Congress of Applied Mechanics, Zurich (1926) 332-335.
D. J. Segalman: A four-parameter Iwan model for lap-type joints. Journal of Applied Mechanics 72
(2005) 752-760.
"""

from typing import NamedTuple, Self

import numpy as np
from numpy.linalg import multi_dot
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop, loop
from boltjoint.friction.aft_kernels import Array
from boltjoint.friction.modal_elements import HarmonicBasis

#: elements whose derivatives are formed together, so that they stay small
_ELEMENTS_AT_ONCE = 256


class Hysteresis(NamedTuple):
    """Iwan elements along a period of samples, each of shape (elements, samples).

    Parameters
    ----------
    force
        Of each element [N].
    stiffness
        Slope of the branch [N/m].
    reversal
        Sample of the reversal from which the branch started, -1 on first loading.
    first
        Sample of the largest displacement, shape (elements,).
    """

    force: Array
    stiffness: Array
    reversal: NDArray[np.int32]
    first: NDArray[np.int64]

    @classmethod
    def of(cls, quantities: Array, displacement: Array) -> Self:
        """Hysteresis along displacements [m], (elements, samples).

        ``quantities`` are those of ``FourParameterIwan.compiled_elements``.
        """
        displacement = np.ascontiguousarray(displacement)
        force, stiffness = np.empty((2, *displacement.shape))
        reversal = np.empty(displacement.shape, np.int32)
        first = np.empty(len(displacement), np.int64)
        _follow(quantities, displacement, force, stiffness, reversal, first)
        return cls(force, stiffness, reversal, first)

    def change(self, displacement: Array) -> Array:
        """Change of the forces [N] along a change of the displacements [m]."""
        force = np.empty_like(self.force)
        _follow_change(*self[1:], np.ascontiguousarray(displacement), force)
        return force

    def tangents(self, synthesis: Array, weight: Array, *, delayed: bool = False) -> Array:
        """Derivatives of the harmonic forces of each element, (elements, components, components).

        Parameters
        ----------
        synthesis, weight
            As of ``SampleTables``.
        delayed
            Each derivative by the displacement at a sample times the samples since then.
        """
        count = len(synthesis)
        tangents = np.empty((len(self.force), count, count))
        contribution = np.ascontiguousarray(synthesis.T * weight)
        _add_up(*self[1:], np.ascontiguousarray(synthesis), contribution, delayed, tangents)
        return tangents


class ModalIwan(NamedTuple):
    """Iwan elements in modal coordinates.

    ``R`` has the modal rows of their displacements, shape (elements, modes); ``quantities`` as for
    ``Hysteresis.of``.
    """

    R: Array
    quantities: Array

    def force_and_tangent(
        self, basis: HarmonicBasis, amplitude: Array
    ) -> tuple[Array, "ModalIwanTangent"]:
        """As ``ModalElements.force_and_tangent``."""
        hysteresis = self._follow(basis, amplitude)
        return _in_modes(self.R, basis, hysteresis.force), ModalIwanTangent(
            self.R, basis, hysteresis
        )

    def delay(self, basis: HarmonicBasis, amplitude: Array) -> Array:
        """As ``ModalElements.delay``."""
        hysteresis = self._follow(basis, amplitude)
        return _sum_of_tangents(self.R, basis, hysteresis, delayed=True) / len(basis.synthesis.T)

    def _follow(self, basis: HarmonicBasis, amplitude: Array) -> Hysteresis:
        displacement = multi_dot([self.R, amplitude.T, basis.synthesis])
        return Hysteresis.of(self.quantities, displacement)


class ModalIwanTangent(NamedTuple):
    """As ``ModalTangent``, of Iwan elements."""

    R: Array
    basis: HarmonicBasis
    hysteresis: Hysteresis

    def __call__(self) -> Array:
        """D force[i, r] / d amplitude[j, s], shape (components, modes, components, modes)."""
        return _sum_of_tangents(self.R, self.basis, self.hysteresis)

    def along(self, change: Array) -> Array:
        """Derivative of the forces along a change of the amplitudes, both (components, modes)."""
        displacement = multi_dot([self.R, change.T, self.basis.synthesis])
        return _in_modes(self.R, self.basis, self.hysteresis.change(displacement))


def _in_modes(R: Array, basis: HarmonicBasis, force: Array) -> Array:
    """Harmonic forces on the modes of forces at the samples, shape (components, modes)."""
    return multi_dot([basis.synthesis, force.T, R]) * basis.weight[:, None]


def _sum_of_tangents(
    R: Array, basis: HarmonicBasis, hysteresis: Hysteresis, *, delayed: bool = False
) -> Array:
    """Derivatives of all elements in modal coordinates, (components, modes) twice."""
    modes, count = R.shape[1], len(basis.weight)
    total = np.zeros((modes * modes, count * count))
    for begin in range(0, len(R), _ELEMENTS_AT_ONCE):
        at = slice(begin, begin + _ELEMENTS_AT_ONCE)
        some = Hysteresis(*(each[at] for each in hysteresis))
        tangents = some.tangents(basis.synthesis, basis.weight, delayed=delayed)
        products = (R[at, :, None] * R[at, None, :]).reshape(-1, modes * modes)
        total += products.T @ tangents.reshape(-1, count * count)
    return total.reshape(modes, modes, count, count).transpose(2, 0, 3, 1)


@loop
def _first_loading(
    k_p: float, phi: float, chi: float, beta: float, u: float
) -> tuple[float, float]:
    """Force and stiffness on first loading by u >= 0."""
    if u >= phi:
        return k_p * phi * (beta + (chi + 1) / (chi + 2)), 0.0
    part = (u / phi) ** (chi + 1)
    return k_p * u * (1 + beta - part / (chi + 2)), k_p * (1 + beta - part)


@kept_loop
def _follow(
    quantities: Array,
    u: Array,
    force: Array,
    stiffness: Array,
    reversal: NDArray[np.int32],
    first: NDArray[np.int64],
) -> None:
    """Follow the elements through a period from their largest displacement."""
    elements, samples = u.shape
    # reversals that are remembered, the oldest first
    memory = np.empty(samples + 1, np.int64)
    for e in range(elements):
        k_p, phi, chi, beta = quantities[0, e], quantities[1, e], quantities[2, e], quantities[3, e]
        begin = 0
        for i in range(1, samples):
            if abs(u[e, i]) > abs(u[e, begin]):
                begin = i
        first[e] = begin
        count, before, direction = 0, begin, np.sign(u[e, begin])
        for i in range(begin, begin + samples):
            at = i % samples
            now = u[e, at]
            heading = np.sign(now - u[e, before])
            if heading not in (0.0, direction):
                memory[count] = before
                count, direction = count + 1, heading
            before = at
            while count > 1 and (now - u[e, memory[count - 2]]) * direction >= 0:
                count -= 2
            if count == 0:
                reversal[e, at] = -1
                loading, stiffness[e, at] = _first_loading(k_p, phi, chi, beta, abs(now))
                force[e, at] = np.sign(now) * loading
            else:
                last = memory[count - 1]
                reversal[e, at] = last
                moved = now - u[e, last]
                half, stiffness[e, at] = _first_loading(k_p, phi, chi, beta, abs(moved) / 2)
                force[e, at] = force[e, last] + np.sign(moved) * 2 * half


@kept_loop
def _follow_change(
    stiffness: Array, reversal: NDArray[np.int32], first: NDArray[np.int64], u: Array, force: Array
) -> None:
    """Changes of the forces along the branches, of changes of the displacements."""
    elements, samples = u.shape
    for e in range(elements):
        for i in range(first[e], first[e] + samples):
            at = i % samples
            last = reversal[e, at]
            if last < 0:
                force[e, at] = stiffness[e, at] * u[e, at]
            else:
                force[e, at] = force[e, last] + stiffness[e, at] * (u[e, at] - u[e, last])


@loop
def _by_displacement(
    stiffness: Array, reversal: NDArray[np.int32], first: int, weight: Array, found: Array
) -> None:
    """Derivatives of weighted sums of the forces of an element by its displacements.

    ``weight`` has the weights of the samples in each sum, (samples, sums); so has what is found.
    """
    samples, sums = weight.shape
    # weights of the force at a sample and of all that start from there
    whole = weight.copy()
    found[:] = 0.0
    for i in range(first + samples - 1, first - 1, -1):
        at = i % samples
        last = reversal[at]
        for c in range(sums):
            change = stiffness[at] * whole[at, c]
            found[at, c] += change
            if last >= 0:
                found[last, c] -= change
                whole[last, c] += whole[at, c]


@kept_loop
def _add_up(
    stiffness: Array,
    reversal: NDArray[np.int32],
    first: NDArray[np.int64],
    synthesis: Array,
    contribution: Array,
    delayed: bool,
    tangents: Array,
) -> None:
    """Derivatives of the harmonic forces of each element by its harmonic displacements."""
    count, samples = synthesis.shape
    found, late = np.empty((samples, count)), np.empty((samples, count))
    later, displaced = np.empty((samples, count)), np.empty((count, samples))
    for e in range(len(stiffness)):
        branches = stiffness[e], reversal[e], first[e]
        _by_displacement(*branches, contribution, found)
        if not delayed:
            tangents[e] = np.dot(found.T, synthesis.T)
            continue
        # times of force and displacement from the largest displacement on
        for i in range(samples):
            at = (first[e] + i) % samples
            later[at] = i * contribution[at]
            displaced[:, at] = i * synthesis[:, at]
        _by_displacement(*branches, later, late)
        tangents[e] = np.dot(late.T, synthesis.T) - np.dot(found.T, displaced.T)
