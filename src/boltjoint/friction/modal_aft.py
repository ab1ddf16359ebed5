"""AFT in modal coordinates: elements are summed at every sample before the Fourier transforms.

Between two changes of its contact state the force of an element is linear in the displacement at
the same sample and at the one that determined its slider. So the tangent of all elements is made of
two sums over the samples: G(t) of the derivatives by the displacement at t, which changes only with
contact states, and those by the displacement at the samples that determine sliders. Its cost hardly
grows with the number of elements, and with the square of the harmonics only as the Jacobian does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.linalg import multi_dot
from scipy.linalg import get_blas_funcs

from boltjoint.friction.modal_kernels import (
    follow,
    follow_change,
    hold,
    subtract,
    sum_positions,
    sum_products,
    sum_stiffness,
)
from boltjoint.friction.protocol import HarmonicBasis
from boltjoint.friction.sliders_at_samples import Array, Sliders

#: samples whose derivatives are transformed to harmonics at once, at least
_SAMPLES_AT_ONCE = 64
#: elements followed at once where their derivatives are not needed together: they stay small
_ELEMENTS_AT_ONCE = 4096
#: of a product with sums over the elements, which are read from memory, over one of each element
_COST_OF_SUMS = 4


class ModalSliders(NamedTuple):
    """Springs with sliders in modal coordinates.

    ``x = X q`` and ``n = n0 + V q`` are the forces of their springs; R and N, of the same shape
    (elements, modes), project friction force and normal load onto the modes; V and N are None
    where the normal load is constant. ``normal_load`` n0 and ``friction_coefficient`` have the
    shape (elements,).
    """

    R: Array
    N: Array | None
    X: Array
    V: Array | None
    normal_load: Array
    friction_coefficient: Array

    @classmethod
    def of(cls, sliders: Sliders, rows: Sequence[Array]) -> Self:
        """Sliders by the modal rows of their points in each direction, each (points, modes)."""
        on, lateral = sliders.point, sliders.lateral
        R = rows[0][on] if lateral is None else np.where(lateral[:, None], rows[1][on], rows[0][on])
        N = V = None
        if sliders.normal_stiffness is not None:
            N = rows[-1][on]
            V = sliders.normal_stiffness[:, None] * N
            if lateral is not None:
                # two sliders have a normal load in common, and it acts once
                N = np.where(lateral[:, None], 0.0, N)
        X = sliders.tangential_stiffness[:, None] * R
        return cls(R, N, X, V, sliders.normal_load, sliders.friction_coefficient)

    def part(self, at: slice) -> "ModalSliders":
        """Some of the sliders."""
        return ModalSliders(
            self.R[at],
            None if self.N is None else self.N[at],
            self.X[at],
            None if self.V is None else self.V[at],
            self.normal_load[at],
            self.friction_coefficient[at],
        )

    def by_motion(self, changes: Array) -> Array:
        """Derivatives ``by_x X + by_n V`` by the modes, of some changes, (changes, modes)."""
        _, element, by_x, by_n = changes[:, :4].T
        on = element.astype(np.int64)
        derivative = by_x[:, None] * self.X[on]
        if self.V is not None:
            derivative += by_n[:, None] * self.V[on]
        return derivative

    def force_and_tangent(
        self, basis: HarmonicBasis, amplitude: Array
    ) -> tuple[Array, "ModalSliderTangent"]:
        """As ``ModalElements.force_and_tangent``."""
        x, n = _spring_forces(self, amplitude, basis)
        friction = np.empty_like(x)
        changes = _Changes(*follow(x, n, self.friction_coefficient, friction))
        load = np.maximum(n, 0.0)
        load -= np.maximum(self.normal_load, 0.0)
        force = _in_modes(self, basis, friction, load)
        return force, ModalSliderTangent(self, basis, changes, (x, n, friction, load))

    def delay(self, basis: HarmonicBasis, amplitude: Array) -> Array:
        """As ``ModalElements.delay``."""
        return slider_delay(self, basis, amplitude)


class _Changes(NamedTuple):
    """Derivatives of the elements that begin at a sample, a row for each.

    ``of_state`` by the displacement at the same time, while in contact: sample, element,
    derivatives of the friction by x and by n, and the sample at which they end. ``of_slider`` by
    the displacement at the sample that determined the slider: sample, element, the derivatives of
    its position by x and by n, and the samples between which it stays.
    """

    of_state: Array
    of_slider: Array


@dataclass(frozen=True, eq=False)
class ModalSliderTangent:
    """As ``ModalTangent``, of sliders.

    ``work`` has arrays for x, n, friction and load, each (samples, elements), n and load of a
    constant load (1, elements): new ones cost as much as what is done with them.
    """

    elements: ModalSliders
    basis: HarmonicBasis
    changes: _Changes
    work: tuple[Array, Array, Array, Array]

    def __call__(self, precision: type[np.floating] = np.float64) -> Array:
        """D force[i, r] / d amplitude[j, s], shape (components, modes, components, modes)."""
        mean, of_slider = self.basis.mean, self.changes.of_slider
        begin, end = of_slider[:, 4:].T.astype(np.int64)
        held = (mean[end] - mean[begin]).astype(precision, copy=False)
        tangent = _by_state(self._stiffness, self.basis, precision)
        subtract(_by_slider(self.elements, self.basis, of_slider, held), tangent)
        return tangent

    def along(self, change: Array) -> Array:
        """Derivative of the forces along a change of the amplitudes, both (components, modes)."""
        elements, basis = self.elements, self.basis
        sums = change.shape[1] ** 2 * _COST_OF_SUMS
        if sums < elements.R.size * (2 if elements.V is None else 4):
            return self._along_sums(change)
        x, n, friction, load = self.work
        for rows, change_along in ((elements.X, x), (elements.V, n)):
            if rows is not None:
                multi_dot([basis.synthesis.T, change, rows.T], out=change_along)
        friction[:] = load[:] = 0.0
        follow_change(x, n, *self.changes, friction, load)
        return _in_modes(elements, basis, friction, load)

    def _along_sums(self, change: Array) -> Array:
        """As ``along``, by the sums over the elements at each sample: of many elements cheaper."""
        motion = self.basis.synthesis.T @ change
        sample = self.changes.of_slider[:, 0].astype(np.int64)
        position = np.einsum("ij,ij->i", self._positions, motion[sample])
        held = np.zeros_like(motion)
        hold(position, self.changes.of_slider, self.elements.R, held)
        force = (self._stiffness @ motion[:, :, None])[:, :, 0] - np.cumsum(held, axis=0)
        return (self.basis.synthesis @ force) * self.basis.weight[:, None]

    @cached_property
    def _positions(self) -> Array:
        """Positions of the sliders by the displacement that determined them, (changes, modes)."""
        return self.elements.by_motion(self.changes.of_slider)

    @cached_property
    def _stiffness(self) -> Array:
        """G(t), the derivative by the displacement at the same time, (samples, modes, modes)."""
        elements, modes = self.elements, self.elements.R.shape[1]
        none = np.zeros((0, modes))
        N, V = (none if rows is None else rows for rows in (elements.N, elements.V))
        G = np.zeros((self.basis.synthesis.shape[1], modes, modes))
        of_state = self.changes.of_state
        sum_stiffness(of_state, elements.by_motion(of_state), elements.R, N, V, G)
        return G


def slider_delay(elements: ModalSliders, basis: HarmonicBasis, amplitude: Array) -> Array:
    """Derivative of the harmonic forces by the rate at which a change of the motion grows.

    Under a change ``exp(r t)`` times a periodic one, a slider holds what the motion was at the time
    tau before, at which it was determined: in the derivative of the forces its part is multiplied
    by ``exp(-r tau)``. This is the derivative of that by r at r = 0, with r over a period.

    Parameters
    ----------
    elements, basis, amplitude
        As for ``modal_force_and_tangent``.

    Returns
    -------
    ndarray
        By the derivative of the forces [s^-2], shape (components, modes, components, modes).
        Sliders that rest for the whole period have no part in it.
    """
    samples = basis.synthesis.shape[1]
    # sums of the contributions of samples times their number, for the mean delay of an interval
    contribution = basis.synthesis.T * basis.weight
    moment = np.zeros_like(basis.mean)
    np.cumsum(np.arange(samples)[:, None] * contribution, axis=0, out=moment[1:])

    modes, count = elements.R.shape[1], basis.harmonic.size
    delay = np.zeros((count, modes, modes, count))
    for first in range(0, len(elements.R), _ELEMENTS_AT_ONCE):
        at = slice(first, first + _ELEMENTS_AT_ONCE)
        block = elements.part(at)
        x, n = _spring_forces(block, amplitude, basis)
        of_slider = follow(x, n, block.friction_coefficient, np.empty_like(x))[1]
        of_slider = of_slider[of_slider[:, 5] - of_slider[:, 4] < samples]
        sample, begin, end = of_slider[:, [0, 4, 5]].T.astype(np.int64)
        since = (begin - sample) % samples - begin
        held = moment[end] - moment[begin] + since[:, None] * (basis.mean[end] - basis.mean[begin])
        delay += _by_slider(block, basis, of_slider, held)
    return delay.transpose(0, 1, 3, 2) / samples


def _in_modes(elements: ModalSliders, basis: HarmonicBasis, friction: Array, load: Array) -> Array:
    """Harmonic forces on the modes of forces at the samples, shape (components, modes)."""
    force = multi_dot([basis.synthesis, friction, elements.R])
    if elements.N is not None:
        force += multi_dot([basis.synthesis, load, elements.N])
    return force * basis.weight[:, None]


def _spring_forces(
    elements: ModalSliders, amplitude: Array, basis: HarmonicBasis
) -> tuple[Array, Array]:
    """Forces of the springs of the elements at the samples, each (samples, elements).

    A constant normal load has the shape (1, elements).
    """
    x = multi_dot([basis.synthesis.T, amplitude, elements.X.T])
    if elements.V is None:
        return x, elements.normal_load[None]
    n = multi_dot([basis.synthesis.T, amplitude, elements.V.T])
    n += elements.normal_load
    return x, n


def _by_state(stiffness: Array, basis: HarmonicBasis, precision: type[np.floating]) -> Array:
    """Derivative by the displacements at the same time, (components, modes, components, modes).

    ``sum_t phi_i(t) G(t) phi_j(t)``: products of two harmonics are the harmonics of sum and
    difference of their numbers.
    """
    spectrum = np.fft.fft(stiffness, axis=0)
    real, imaginary = np.ascontiguousarray(spectrum.real), np.ascontiguousarray(spectrum.imag)
    count, modes = basis.harmonic.size, stiffness.shape[1]
    products = np.empty((count, modes, count, modes), precision)
    sum_products(real, imaginary, basis.harmonic, basis.is_sine, 0.5 * basis.weight, products)
    return products


def _by_slider(
    elements: ModalSliders, basis: HarmonicBasis, of_slider: Array, held: Array
) -> Array:
    """Derivative by the displacements that determined sliders.

    ``held`` has the components of a position of one while it is held, (changes, components), in the
    precision of the sums. The axes are those of ``ModalTangent``, but the components of the motion
    come last.
    """
    precision = held.dtype
    modes, count = elements.R.shape[1], basis.harmonic.size
    order = np.argsort(of_slider[:, 0], kind="stable")
    of_slider, held = of_slider[order], held[order]
    samples, first = np.unique(of_slider[:, 0].astype(np.int64), return_index=True)
    first = np.append(first, len(of_slider))
    element = of_slider[:, 1].astype(np.int64)
    positions = elements.by_motion(of_slider).astype(precision, copy=False)
    R = elements.R.astype(precision, copy=False)
    synthesis = basis.synthesis.astype(precision, copy=False)
    at_once = max(_SAMPLES_AT_ONCE, count)
    rows = np.empty((min(samples.size, at_once), count * modes * modes), precision)
    tangent = np.zeros((count * modes * modes, count), precision)
    (gemm,) = get_blas_funcs(("gemm",), (tangent,))
    for begin in range(0, samples.size, at_once):
        together = slice(begin, min(begin + at_once, samples.size))
        derivative = rows[: together.stop - begin]
        bounds = first[begin : together.stop + 1]
        sum_positions(element, positions, held, bounds, R, derivative)
        at = synthesis[:, samples[together]]
        # tangent += derivative.T @ at.T, in place: a new array of its size costs as much
        gemm(1.0, at, derivative.T, beta=1.0, c=tangent.T, trans_b=True, overwrite_c=True)
    return tangent.reshape(count, modes, modes, count)
