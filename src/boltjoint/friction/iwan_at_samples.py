"""Hysteresis of Iwan elements at the samples of a period, by Masing's rule with a memory.

From a reversal of the motion at (u_r, f_r) the force follows the curve F of first loading, twice as
large, ``f = f_r +- 2 F(|u - u_r| / 2)``, until it meets the branch that was left at the reversal
before, and follows that one again (Masing 1926). The largest displacement of a period lies on the
curve of first loading itself: from there on a single period is the steady state. So the whole
distribution slips, and sticks, as it does along the motion. Reversals lie between samples: they are
the vertices of parabolas through three of them. In microslip the force of one harmonic so has an
error of third order in the sampling interval; at the corner where all of an element begins to slip
it is of second order.

A change of the motion changes forces along the same branches, ``df = df_r + F'(|u - u_r| / 2) (du -
du_r)``. It is followed along the period, or, for the derivatives of harmonic forces by all
displacements at once, against it.

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
from boltjoint.friction.protocol import HarmonicBasis
from boltjoint.friction.sliders_at_samples import Array

#: origin where there is no reversal
_NO_REVERSAL = -2

#: elements whose derivatives are formed together, so that they stay small
_ELEMENTS_AT_ONCE = 256


class Hysteresis(NamedTuple):
    """Iwan elements along a period of samples.

    Parameters
    ----------
    force
        Force of each element [N], shape (elements, samples).
    stiffness
        Slope of the branch of each sample, and of that which ends at a reversal near it [N/m],
        shape (2, elements, samples).
    origin
        Sample of the reversal from which these branches started, -1 on first loading; -2 where
        there is no reversal; shape of ``stiffness``.
    offset
        Time from the sample to its reversal, over the sampling interval, (elements, samples).
    first
        Sample of the largest displacement, shape (elements,).
    """

    force: Array
    stiffness: Array
    origin: NDArray[np.int32]
    offset: Array
    first: NDArray[np.int64]

    @classmethod
    def of(cls, quantities: Array, displacement: Array) -> Self:
        """Hysteresis along displacements [m], (elements, samples).

        ``quantities`` are those of ``FourParameterIwan.compiled_elements``.
        """
        shape = displacement.shape
        force, offset, stiffness = np.empty(shape), np.zeros(shape), np.zeros((2, *shape))
        origin, first = np.full((2, *shape), _NO_REVERSAL, np.int32), np.empty(len(force), np.int64)
        hysteresis = cls(force, stiffness, origin, offset, first)
        _follow(quantities, np.ascontiguousarray(displacement), hysteresis)
        return hysteresis

    def change(self, displacement: Array) -> Array:
        """Change of the forces [N] along a change of the displacements [m]."""
        force = np.empty_like(self.force)
        _follow_change(self, np.ascontiguousarray(displacement), force)
        return force

    def tangents(
        self,
        synthesis: Array,
        weight: Array,
        elements: slice = slice(None),
        *,
        delayed: bool = False,
    ) -> Array:
        """Derivatives of the harmonic forces of elements, shape (elements, components, components).

        Parameters
        ----------
        synthesis, weight
            As of ``SampleTables``.
        elements
            Which; all by default.
        delayed
            Instead, the derivative of these by the rate at which a change of the motion grows, over
            a sample: each part is held from the displacement at an earlier sample.
        """
        of_each = np.arange(len(self.force))[elements]
        tangents = np.empty((of_each.size, len(weight), len(weight)))
        _add_up(self, of_each, np.ascontiguousarray(synthesis.T), weight, delayed, tangents)
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

    def __call__(self, precision: type[np.floating] = np.float64) -> Array:
        """D force[i, r] / d amplitude[j, s], shape (components, modes, components, modes)."""
        return _sum_of_tangents(self.R, self.basis, self.hysteresis).astype(precision, copy=False)

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
        tangents = hysteresis.tangents(basis.synthesis, basis.weight, at, delayed=delayed)
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


@loop
def _vertex(before: float, at: float, after: float) -> tuple[float, float]:
    """Vertex of the parabola through three samples: time from the second, and value."""
    slope, bend = (after - before) / 2, after - 2 * at + before
    if bend == 0.0:
        return 0.0, at
    offset = -slope / bend
    return offset, at + offset * slope / 2


@loop
def _largest(u: Array) -> int:
    """Sample next to the largest vertex without sign."""
    samples, largest, place = u.size, -1.0, 0
    for at in range(samples):
        before, after = u[at - 1], u[(at + 1) % samples]
        sign = np.sign(u[at])
        if sign * (u[at] - before) >= 0 and sign * (u[at] - after) >= 0:
            size = abs(_vertex(before, u[at], after)[1])
            if size > largest:
                place, largest = at, size
    return place


@kept_loop
def _follow(quantities: Array, displacement: Array, hysteresis: Hysteresis) -> None:
    """Follow the elements through a period from their largest displacement."""
    samples = displacement.shape[1]
    # reversals that are remembered, the oldest first: sample, displacement, force
    memory = np.empty(samples + 1, np.int64)
    u_r, f_r = np.empty(samples + 1), np.empty(samples + 1)
    for e in range(len(displacement)):
        shape = quantities[0, e], quantities[1, e], quantities[2, e], quantities[3, e]
        u, force, offset = displacement[e], hysteresis.force[e], hysteresis.offset[e]
        stiffness, origin = hysteresis.stiffness[:, e], hysteresis.origin[:, e]
        begin = hysteresis.first[e] = _largest(u)
        count, before, direction = 0, begin, np.sign(u[begin])
        for i in range(begin, begin + samples):
            at = i % samples
            heading = np.sign(u[at] - u[before])
            if heading not in (0.0, direction):
                offset[before], vertex = _vertex(u[before - 1], u[before], u[at])
                count = _remembered(u_r, count, vertex, direction)
                origin[1, before] = memory[count - 1] if count else -1
                f_r[count], stiffness[1, before] = _on_branch(shape, u_r, f_r, count, vertex)
                memory[count], u_r[count] = before, vertex
                count, direction = count + 1, heading
                if offset[before] < 0:
                    # the sample lies behind the reversal already
                    origin[0, before] = before
                    force[before], stiffness[0, before] = _on_branch(
                        shape, u_r, f_r, count, u[before]
                    )
            before = at
            count = _remembered(u_r, count, u[at], direction)
            origin[0, at] = memory[count - 1] if count else -1
            force[at], stiffness[0, at] = _on_branch(shape, u_r, f_r, count, u[at])


@loop
def _remembered(u_r: Array, count: int, u: float, direction: float) -> int:
    """Reversals that are still remembered when the motion in this direction has come to u."""
    while count > 1 and (u - u_r[count - 2]) * direction >= 0:
        count -= 2
    return count


@loop
def _on_branch(
    shape: tuple[float, float, float, float], u_r: Array, f_r: Array, count: int, u: float
) -> tuple[float, float]:
    """Force and stiffness at u, on the branch from the last of the reversals."""
    if count == 0:
        force, stiffness = _first_loading(*shape, abs(u))
        return np.sign(u) * force, stiffness
    moved = u - u_r[count - 1]
    half, stiffness = _first_loading(*shape, abs(moved) / 2)
    return f_r[count - 1] + np.sign(moved) * 2 * half, stiffness


@loop
def _at_vertex(offset: float) -> tuple[float, float, float]:
    """Derivatives of the value of a vertex by the three samples: those of interpolation there."""
    return offset * (offset - 1) / 2, 1 - offset * offset, offset * (offset + 1) / 2


@kept_loop
def _follow_change(hysteresis: Hysteresis, displacement: Array, change: Array) -> None:
    """Changes of the forces along the branches, of changes of the displacements."""
    samples = displacement.shape[1]
    u_r, f_r = np.empty(samples), np.empty(samples)
    for e in range(len(displacement)):
        u, force, first = displacement[e], change[e], hysteresis.first[e]
        stiffness, origin = hysteresis.stiffness[:, e], hysteresis.origin[:, e]
        for i in range(first, first + samples):
            at = i % samples
            if origin[1, at] != _NO_REVERSAL:
                last = origin[1, at]
                by_before, by_at, by_after = _at_vertex(hysteresis.offset[e, at])
                after = u[(at + 1) % samples]
                u_r[at] = by_before * u[at - 1] + by_at * u[at] + by_after * after
                f_r[at] = stiffness[1, at] * u_r[at]
                if last >= 0:
                    f_r[at] += f_r[last] - stiffness[1, at] * u_r[last]
            last = origin[0, at]
            force[at] = stiffness[0, at] * u[at]
            if last >= 0:
                force[at] += f_r[last] - stiffness[0, at] * u_r[last]


@loop
def _by_displacement(
    stiffness: Array,
    origin: NDArray[np.int32],
    offset: Array,
    first: int,
    weight: Array,
    derivative: Array,
) -> None:
    """Derivatives of weighted sums of the forces of an element by its displacements.

    Rows of ``weight`` and ``found``, (samples + 1, sums), begin at the sample before the first: it
    is one of the three of the first reversal, and has no weight.
    """
    samples, sums = offset.size, weight.shape[1]
    by_u, by_f = np.zeros((samples, sums)), np.zeros((samples, sums))
    derivative[:] = 0.0
    for row in range(samples, 0, -1):
        at = (first + row - 1) % samples
        last, k = origin[0, at], stiffness[0, at]
        for c in range(sums):
            derivative[row, c] += k * weight[row, c]
            if last >= 0:
                by_u[last, c] -= k * weight[row, c]
                by_f[last, c] += weight[row, c]
        if origin[1, at] == _NO_REVERSAL:
            continue
        last, k = origin[1, at], stiffness[1, at]
        by_before, by_at, by_after = _at_vertex(offset[at])
        for c in range(sums):
            by_vertex = by_u[at, c] + k * by_f[at, c]
            derivative[row - 1, c] += by_before * by_vertex
            derivative[row, c] += by_at * by_vertex
            derivative[row + 1, c] += by_after * by_vertex
            if last >= 0:
                by_u[last, c] -= k * by_f[at, c]
                by_f[last, c] += by_f[at, c]


@kept_loop
def _add_up(
    hysteresis: Hysteresis,
    elements: NDArray[np.int64],
    components: Array,
    weight: Array,
    delayed: bool,
    tangents: Array,
) -> None:
    """Derivatives of the harmonic forces of elements by their harmonic displacements.

    ``components`` has the values of the harmonic components at the samples, (samples, components).
    """
    samples, count = components.shape
    shape = samples + 1, count
    # displacement and force, and both times the samples before
    displacement, force, derivative = np.empty(shape), np.empty(shape), np.empty(shape)
    timed, force_timed = np.empty(shape), np.empty(shape)
    for place, e in enumerate(elements):
        first = hysteresis.first[e]
        branches = hysteresis.stiffness[:, e], hysteresis.origin[:, e], hysteresis.offset[e], first
        # not by the broadcasting of arrays, which takes two seconds to compile
        for row in range(samples + 1):
            for c in range(count):
                u = components[(first + row - 1) % samples, c]
                f = weight[c] * u if row > 0 else 0.0
                displacement[row, c], force[row, c] = u, f
                if delayed:
                    timed[row, c], force_timed[row, c] = row * u, row * f
        _by_displacement(*branches, force, derivative)
        if not delayed:
            np.dot(derivative.T, displacement, tangents[place])
            continue
        # each part is multiplied by exp(-r tau), tau the time between displacement and force
        of_displacement = np.dot(derivative.T, timed)
        _by_displacement(*branches, force_timed, derivative)
        at_force = np.dot(derivative.T, displacement)
        for i in range(count):
            for j in range(count):
                tangents[place, i, j] = of_displacement[i, j] - at_force[i, j]
