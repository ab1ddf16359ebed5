"""AFT in modal coordinates: elements are summed at every sample before the Fourier transforms.

Between two changes of its contact state the force of an element is linear in the displacement at
the same sample and at the one that determined its slider. So the tangent of all elements is made of
two sums over the samples: G(t) of the derivatives by the displacement at t, which changes only with
contact states, and those by the displacement at the samples that determine sliders. Its cost hardly
grows with the number of elements, and with the square of the harmonics only as the Jacobian does.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.linalg import multi_dot
from numpy.typing import NDArray
from scipy.linalg.blas import dgemm

from boltjoint.compiled import kept_loop
from boltjoint.friction.protocol import HarmonicBasis
from boltjoint.friction.sliders_at_samples import (
    CLOSING,
    SEPARATION,
    SLIP_NEGATIVE,
    SLIP_POSITIVE,
    STICK,
    Array,
    Sliders,
    move_through_period,
    slider_derivative,
)

#: samples whose derivatives are transformed to harmonics at once, so that they stay small
_SAMPLES_AT_ONCE = 64
#: elements followed at once where their derivatives are not needed together, for the same reason
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

    def by_displacement(self, on: NDArray[np.int64], by_x: Array, by_n: Array) -> Array:
        """Derivatives ``by_x X + by_n V`` of some elements by the modes, (elements, modes)."""
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
        changes = _Changes(*_follow(x, n, self.friction_coefficient, friction))
        load = np.maximum(n, 0.0) - np.maximum(self.normal_load, 0.0)[:, None]
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

    ``work`` has arrays for x, n, friction and load, each (elements, samples): new ones cost as much
    as what is done with them.
    """

    elements: ModalSliders
    basis: HarmonicBasis
    changes: _Changes
    work: tuple[Array, Array, Array, Array]

    def __call__(self) -> Array:
        """D force[i, r] / d amplitude[j, s], shape (components, modes, components, modes)."""

        def during(_: int, begin: NDArray[np.int64], end: NDArray[np.int64]) -> Array:
            return self.basis.mean[end] - self.basis.mean[begin]

        by_state = _by_state(self._stiffness, self.basis)
        by_slider = _by_slider(self.elements, self.basis, self.changes.of_slider, during)
        return by_state.transpose(0, 2, 1, 3) - by_slider.transpose(2, 0, 3, 1)

    def along(self, change: Array) -> Array:
        """Derivative of the forces along a change of the amplitudes, both (components, modes)."""
        elements, basis = self.elements, self.basis
        sums = change.shape[1] ** 2 * _COST_OF_SUMS
        if sums < elements.R.size * (2 if elements.V is None else 4):
            return self._along_sums(change)
        x, n, friction, load = self.work
        n[:] = 0.0
        for rows, change_along in ((elements.X, x), (elements.V, n)):
            if rows is not None:
                multi_dot([rows, change.T, basis.synthesis], out=change_along)
        friction[:] = load[:] = 0.0
        _follow_change(x, n, *self.changes, friction, load)
        return _in_modes(elements, basis, friction, load)

    def _along_sums(self, change: Array) -> Array:
        """As ``along``, by the sums over the elements at each sample: of many elements cheaper."""
        motion = self.basis.synthesis.T @ change
        sample = self.changes.of_slider[:, 0].astype(np.int64)
        position = np.einsum("ij,ij->i", self._positions, motion[sample])
        held = np.zeros_like(motion)
        _hold(position, self.changes.of_slider, self.elements.R, held)
        force = (self._stiffness @ motion[:, :, None])[:, :, 0] - np.cumsum(held, axis=0)
        return (self.basis.synthesis @ force) * self.basis.weight[:, None]

    @cached_property
    def _positions(self) -> Array:
        """Positions of the sliders by the displacement that determined them, (changes, modes)."""
        _, on, by_x, by_n, *_ = self.changes.of_slider.T
        return self.elements.by_displacement(on.astype(np.int64), by_x, by_n)

    @cached_property
    def _stiffness(self) -> Array:
        """G(t), the derivative by the displacement at the same time, (samples, modes, modes)."""
        elements, samples = self.elements, self.basis.synthesis.shape[1]
        modes = elements.R.shape[1]
        G = np.zeros((samples, modes, modes))
        sample, element, by_x, by_n, end = self.changes.of_state.T
        begins = np.stack([sample, element, by_x, by_n, np.ones_like(end)], axis=1)
        ends = np.stack([end, element, -by_x, -by_n, -np.ones_like(end)], axis=1)
        changes = np.concatenate([begins, ends[end < samples]])
        for sample, on, (by_x, by_n, load_by_n) in _by_sample(changes):
            if elements.V is not None and elements.N is not None:
                G[sample] += elements.N[on].T @ (load_by_n[:, None] * elements.V[on])
            G[sample] += elements.R[on].T @ elements.by_displacement(on, by_x, by_n)
        return np.cumsum(G, axis=0, out=G)


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

    def delayed(sample: int, begin: NDArray[np.int64], end: NDArray[np.int64]) -> Array:
        since = (begin - sample) % samples - begin
        return moment[end] - moment[begin] + since[:, None] * (basis.mean[end] - basis.mean[begin])

    modes, count = elements.R.shape[1], basis.harmonic.size
    delay = np.zeros((modes, modes, count, count))
    for first in range(0, len(elements.R), _ELEMENTS_AT_ONCE):
        at = slice(first, first + _ELEMENTS_AT_ONCE)
        block = elements.part(at)
        x, n = _spring_forces(block, amplitude, basis)
        of_slider = _follow(x, n, block.friction_coefficient, np.empty_like(x))[1]
        moving = of_slider[:, 5] - of_slider[:, 4] < samples
        delay += _by_slider(block, basis, of_slider[moving], delayed)
    return delay.transpose(2, 0, 3, 1) / samples


def _in_modes(elements: ModalSliders, basis: HarmonicBasis, friction: Array, load: Array) -> Array:
    """Harmonic forces on the modes of forces at the samples, shape (components, modes)."""
    force = multi_dot([basis.synthesis, friction.T, elements.R])
    if elements.N is not None:
        force += multi_dot([basis.synthesis, load.T, elements.N])
    return force * basis.weight[:, None]


def _spring_forces(
    elements: ModalSliders, amplitude: Array, basis: HarmonicBasis
) -> tuple[Array, Array]:
    """Forces of the springs of the elements at the samples, each (elements, samples)."""
    x = multi_dot([elements.X, amplitude.T, basis.synthesis])
    n = np.repeat(elements.normal_load[:, None], x.shape[1], axis=1)
    if elements.V is not None:
        n += multi_dot([elements.V, amplitude.T, basis.synthesis])
    return x, n


def _by_state(stiffness: Array, basis: HarmonicBasis) -> Array:
    """Derivative by the displacements at the same time, (components, components, modes, modes).

    ``sum_t phi_i(t) G(t) phi_j(t)``: products of two harmonics are the harmonics of sum and
    difference of their numbers.
    """
    samples, modes = stiffness.shape[:2]
    spectrum = np.fft.fft(stiffness.reshape(samples, -1), axis=0)
    h = basis.harmonic
    products = np.empty((h.size, h.size, modes * modes))
    for of_force, i in _by_part(basis):
        for of_motion, j in _by_part(basis):
            total = spectrum[(h[i][:, None] + h[j]) % samples]
            difference = spectrum[(h[i][:, None] - h[j]) % samples]
            # the spectrum is the sum with cos, less i times that with sin
            if of_force == of_motion:
                part = difference.real + (total.real if of_force == "cos" else -total.real)
            else:
                part = -total.imag + (-difference.imag if of_force == "sin" else difference.imag)
            products[np.ix_(i, j)] = 0.5 * basis.weight[i][:, None, None] * part
    return products.reshape(h.size, h.size, modes, modes)


def _by_slider(
    elements: ModalSliders,
    basis: HarmonicBasis,
    of_slider: Array,
    during: Callable[[int, NDArray[np.int64], NDArray[np.int64]], Array],
) -> Array:
    """Derivative by the displacements that determined sliders, (modes, modes, comps, comps).

    ``during`` gives the components of positions that are determined at a sample and stay between
    two others, shape (elements, components).
    """
    modes, count = elements.R.shape[1], basis.harmonic.size
    tangent = np.zeros((modes * modes * count, count))
    groups = list(_by_sample(of_slider))
    rows = np.empty((min(len(groups), _SAMPLES_AT_ONCE), modes * modes * count))
    for first in range(0, len(groups), _SAMPLES_AT_ONCE):
        together = groups[first : first + _SAMPLES_AT_ONCE]
        derivative = rows[: len(together)]
        for row, (sample, on, columns) in zip(derivative, together, strict=True):
            by_x, by_n, begin, end = columns
            position = elements.by_displacement(on, by_x, by_n)
            parts = during(sample, begin.astype(np.int64), end.astype(np.int64))
            both = (position[:, :, None] * parts[:, None, :]).reshape(on.size, -1)
            np.matmul(elements.R[on].T, both, out=row.reshape(modes, -1))
        at = basis.synthesis[:, [sample for sample, *_ in together]]
        # tangent += derivative.T @ at.T, in place: a new array of its size costs as much
        dgemm(1.0, at, derivative.T, beta=1.0, c=tangent.T, trans_b=True, overwrite_c=True)
    return tangent.reshape(modes, modes, count, count)


def _by_part(basis: HarmonicBasis) -> tuple[tuple[str, NDArray[np.int64]], ...]:
    """The sine components, and the others."""
    return ("sin", np.flatnonzero(basis.is_sine)), ("cos", np.flatnonzero(~basis.is_sine))


def _by_sample(changes: Array) -> Iterator[tuple[int, NDArray[np.int64], Array]]:
    """Sample, elements and further columns of the changes at each sample that has any."""
    order = np.argsort(changes[:, 0], kind="stable")
    samples, first = np.unique(changes[order, 0], return_index=True)
    after = np.append(first[1:], order.size)
    for sample, begin, end in zip(samples, first, after, strict=False):
        at = order[begin:end]
        yield int(sample), changes[at, 1].astype(np.int64), changes[at, 2:].T


@kept_loop
def _set(row: Array, values: tuple[float, ...]) -> None:
    """Set the columns of a row."""
    for column, value in enumerate(values):
        row[column] = value


@kept_loop
def _follow(x: Array, n: Array, friction_coefficient: Array, friction: Array) -> tuple:
    """Follow the elements through the period: their friction, and where derivatives change."""
    elements, samples = x.shape
    state = np.empty(samples, dtype=np.int8)
    of_state, of_slider = np.empty((8 * elements + 8, 5)), np.empty((4 * elements + 4, 6))
    states = sliders = 0
    for e in range(elements):
        mu = friction_coefficient[e]
        slider_sample, slider_state = move_through_period(x[e], n[e], mu, friction[e], state)
        begin = 0
        for end in range(1, samples + 1):
            current = state[begin]
            if end < samples and state[end] == current:
                continue
            if states + 1 > len(of_state):
                of_state = np.concatenate((of_state, np.empty_like(of_state)))
            if sliders + 2 > len(of_slider):
                of_slider = np.concatenate((of_slider, np.empty_like(of_slider)))
            slips = current == SLIP_NEGATIVE or current == SLIP_POSITIVE
            if current == CLOSING:
                slider_sample, slider_state = begin, current
            if current != SEPARATION:
                by_x, by_n = (0.0, current * mu) if slips else (1.0, 0.0)
                _set(of_state[states], (float(begin), float(e), by_x, by_n, float(end)))
                states += 1
                if not slips and slider_state != STICK:
                    part, by_n_before, by_n = slider_derivative(
                        x[e], n[e], mu, slider_sample, slider_state
                    )
                    during = float(begin), float(end)
                    at = float(slider_sample), float(e)
                    _set(of_slider[sliders], (*at, part, by_n, *during))
                    sliders += 1
                    if slider_state == CLOSING:
                        at = float((slider_sample - 1) % samples), float(e)
                        _set(of_slider[sliders], (*at, 1.0 - part, by_n_before, *during))
                        sliders += 1
            if slips:
                slider_sample, slider_state = end - 1, current
            begin = end
    return of_state[:states], of_slider[:sliders]


@kept_loop
def _follow_change(
    x: Array, n: Array, of_state: Array, of_slider: Array, friction: Array, load: Array
) -> None:
    """Add the changes of friction and load by those of x and n, (elements, samples)."""
    for row in range(len(of_state)):
        e, by_x, by_n = int(of_state[row, 1]), of_state[row, 2], of_state[row, 3]
        for i in range(int(of_state[row, 0]), int(of_state[row, 4])):
            friction[e, i] += by_x * x[e, i] + by_n * n[e, i]
            load[e, i] += n[e, i]
    for row in range(len(of_slider)):
        sample, e = int(of_slider[row, 0]), int(of_slider[row, 1])
        position = of_slider[row, 2] * x[e, sample] + of_slider[row, 3] * n[e, sample]
        for i in range(int(of_slider[row, 4]), int(of_slider[row, 5])):
            friction[e, i] -= position


@kept_loop
def _hold(position: Array, of_slider: Array, R: Array, held: Array) -> None:
    """Add the forces of slider positions where they begin, and take them away where they end."""
    samples, modes = held.shape
    for row in range(len(of_slider)):
        e, begin, end = int(of_slider[row, 1]), int(of_slider[row, 4]), int(of_slider[row, 5])
        for mode in range(modes):
            force = position[row] * R[e, mode]
            held[begin, mode] += force
            if end < samples:
                held[end, mode] -= force
