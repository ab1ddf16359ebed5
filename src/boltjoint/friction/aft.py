"""Friction forces of any number of harmonics by alternating frequency/time (AFT)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.aft_kernels import (
    CLOSES,
    OPEN,
    SLIPS_NEGATIVE,
    SLIPS_POSITIVE,
    STICKS,
    march_points,
    move_slider,
    slider_placement,
)
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.contact_states import SEPARATION, STICK, STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.friction.law import FrictionLaw
from boltjoint.friction.variable import VariableLoad


@dataclass(frozen=True)
class AlternatingFrequencyTime(FrictionLaw):
    """Friction elements of either law, by their march in time instead of their exact harmonics.

    Parameters
    ----------
    elements
        The friction elements.
    harmonics
        The highest harmonic of motion and force.
    samples
        Samples of the period, more than twice the harmonics.

    Raises
    ------
    ValueError
        If the elements are of neither law, there is no harmonic, or there are too few samples to
        tell the harmonics apart.
    """

    elements: ConstantLoad | VariableLoad
    harmonics: int = 1
    samples: int = 256

    def __post_init__(self) -> None:
        """Refuse what cannot be sampled."""
        checks.instance("elements", self.elements, ConstantLoad, VariableLoad)
        checks.whole("harmonics", self.harmonics, at_least=1)
        checks.whole("samples", self.samples, at_least=2 * self.harmonics + 1)

    @property
    def name(self) -> str:
        """The law of the elements."""
        return self.elements.name

    @property
    def directions(self) -> tuple[str, ...]:
        """Directions of motion that the law needs."""
        return self.elements.directions

    @property
    def point_of_element(self) -> NDArray[np.int64]:
        """The contact point each element acts on, counted from 0, shape (elements,)."""
        return self.elements.point_of_element

    @property
    def tangential_stiffness(self) -> NDArray[np.float64]:
        """k_u of each element [N/m], shape (elements,)."""
        return self.elements.tangential_stiffness

    @property
    def slip_force(self) -> NDArray[np.float64]:
        """Mu n of each element in the assembled state [N], shape (elements,)."""
        return self.elements.slip_force

    @cached_property
    def components(self) -> tuple[str, ...]:
        """Harmonic coefficients of motion and force.

        Under constant load half a period mirrors the other, so that no even harmonics arise.
        """
        odd = "bias" not in self.elements.components
        numbers = range(1, self.harmonics + 1, 2 if odd else 1)
        oscillating = [f"{part}{h if h > 1 else ''}" for h in numbers for part in ("sin", "cos")]
        return tuple(oscillating) if odd else ("bias", *oscillating)

    def stuck_stiffness(self, points: int) -> NDArray[np.float64]:
        """Stiffness of the points while nothing slips [N/m], shape (points, directions)."""
        return self.elements.stuck_stiffness(points)

    def evaluate(self, motion: NDArray[np.float64]) -> NDArray[np.float64]:
        """Harmonic forces of all elements on each point, as ``force``."""
        return self._force(motion, np.zeros((0, 0, 0)))

    def evaluate_with_tangent(
        self, motion: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Harmonic forces on each point and their derivative, as ``force_and_tangent``."""
        tangent = np.zeros((*motion.shape, motion.shape[1]))
        return self._force(motion, tangent), tangent

    def modal_force_and_tangent(
        self, rows: tuple[NDArray[np.float64], ...], amplitude: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Harmonic forces in modal coordinates and their derivative, for any number of harmonics.

        What ``force_and_tangent`` gives, taken to modes; like it in iterations, of amplitudes that
        need not be finite. Tangents of points are as large as the
        square of the components; with few modes and many harmonics it is cheaper to add up the
        elements at every sample, and to take the sums to harmonics.

        Parameters
        ----------
        rows
            Modal rows of the points in each direction [kg^-1/2], each (points, modes).
        amplitude
            Modal coordinates by component [kg^1/2 m], shape (components, modes).

        Returns
        -------
        force : ndarray
            Shape (components, modes) [kg^-1/2 N].
        tangent : ndarray
            d force[i, r] / d amplitude[j, s], shape (components, modes, components, modes) [s^-2].

        Raises
        ------
        ValueError
            If shapes do not fit each other, the elements and the components.
        """
        amplitude = checks.array(
            "amplitude", amplitude, (len(self.components), "modes"), finite=False
        )
        if len(rows) != len(self.directions):
            raise ValueError(f"rows has {len(rows)} directions, expected {len(self.directions)}")
        rows = [checks.array("rows", B, ("points", amplitude.shape[1])) for B in rows]
        if min(map(len, rows)) < self._points:
            raise ValueError(f"rows has {min(map(len, rows))} points, expected {self._points}")
        on, k_u, k_v, normal_load, mu = self._arrays()
        R = np.ascontiguousarray(rows[0][on])
        N = np.ascontiguousarray(rows[1][on]) if len(rows) == 2 else np.zeros_like(R)
        count, modes = amplitude.shape
        contribution = self._synthesis * self._weight[:, None]
        total = np.zeros((modes, self.samples))
        # of what the modes do at a sample, on the force at that sample; and on the force as long as
        # a slider stays where it was placed at that sample
        at_once = np.zeros((self.samples + 1, modes, modes))
        held = np.zeros((self.samples, modes, modes, count))
        of_elements = R, N, k_u[:, None] * R, k_v[:, None] * N, normal_load, mu
        _march_in_modes(
            *of_elements, amplitude.T @ self._synthesis, self._mean, total, at_once, held
        )
        by_time = np.cumsum(at_once[:-1], axis=0)
        tangent = (held.reshape(self.samples, -1).T @ self._synthesis.T).reshape(
            modes, modes, count, count
        )
        for r in range(modes):
            for s in range(modes):
                tangent[r, s] += contribution * by_time[:, r, s] @ self._synthesis.T
        return contribution @ total.T, tangent.transpose(2, 0, 3, 1)

    def _states(self, motion: NDArray[np.float64]) -> NDArray[np.int8]:
        on, k_u, k_v, normal_load, mu = self._arrays()
        in_time = self._in_time(motion)[on]
        x = k_u[:, None] * in_time[:, 0]
        n = np.broadcast_to(normal_load[:, None], x.shape)
        if "normal" in self.directions:
            n = n + k_v[:, None] * in_time[:, 1]
        bound = mu[:, None] * np.maximum(n, 0)
        # the bounds leave no room for a slider at rest
        slips = (x - bound).max(axis=1) > (x + bound).min(axis=1)
        state = np.where(slips, STICK_SLIP, STICK)
        state[n.min(axis=1) <= 0] = STICK_SLIP_SEPARATION
        state[n.max(axis=1) <= 0] = SEPARATION
        return state.astype(np.int8)

    def _arrays(self) -> tuple[NDArray, ...]:
        """Point, k_u, k_v, n0 and mu of each element."""
        law = self.elements
        if "normal" in law.directions:
            of_load = law.normal_stiffness, law.normal_load, law.friction_coefficient
        else:
            # only mu n matters where n is constant
            count = law.slip_force.size
            of_load = np.zeros(count), np.ones(count), law.slip_force
        return law.point_of_element, law.tangential_stiffness, *of_load

    @cached_property
    def _synthesis(self) -> NDArray[np.float64]:
        """What each component is at each sample, shape (components, samples)."""
        numbers = sorted({int(name[3:] or 1) for name in self.components if name != "bias"})
        # whole periods are taken off while they are whole numbers, for the sake of rounding
        turns = np.outer(numbers, np.arange(self.samples)) % self.samples / self.samples
        rows = np.stack([np.sin(2 * np.pi * turns), np.cos(2 * np.pi * turns)], axis=1)
        rows = rows.reshape(-1, self.samples)
        return rows if "bias" not in self.components else np.vstack([np.ones(self.samples), rows])

    @cached_property
    def _weight(self) -> NDArray[np.float64]:
        """What a sample counts for in each component, shape (components,)."""
        return np.where(np.array(self.components) == "bias", 1.0, 2.0) / self.samples

    @cached_property
    def _mean(self) -> NDArray[np.float64]:
        """What samples contribute to each component, summed up to each sample.

        Stretches are differences of these sums, of shape (samples + 1, components).
        """
        return _sums(self._synthesis.T * self._weight)

    @cached_property
    def _tables(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """The synthesis, the sums of contributions, and those of their derivatives.

        The last by each component of what is sampled, shape (samples + 1, components, components).
        """
        contribution = self._synthesis.T * self._weight
        square = _sums(contribution[:, :, None] * self._synthesis.T[:, None, :])
        return self._synthesis, self._mean, square

    def _in_time(self, motion: NDArray[np.float64]) -> NDArray[np.float64]:
        """Displacement of the points at the samples [m], shape (points, directions, samples)."""
        components = motion.reshape(-1, len(self.components))
        return (components @ self._synthesis).reshape(len(motion), -1, self.samples)

    def _force(
        self, motion: NDArray[np.float64], tangent: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Force, and tangent where there is room for it."""
        on, *of_element = self._arrays()
        order = np.argsort(on, kind="stable")
        first = np.searchsorted(on[order], np.arange(len(motion) + 1))
        motion, force = np.ascontiguousarray(motion), np.zeros(motion.shape)
        march_points(order, first, *of_element, motion, self._tables, force, tangent)
        return force * np.tile(self._weight, len(self.directions))


def _sums(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sums of the values before each one, and of all, along the first axis."""
    return np.concatenate([np.zeros_like(values[:1]), np.cumsum(values, axis=0)])


@njit(cache=True)
def _march_in_modes(
    R: NDArray[np.float64],
    N: NDArray[np.float64],
    X: NDArray[np.float64],
    V: NDArray[np.float64],
    normal_load: NDArray[np.float64],
    friction_coefficient: NDArray[np.float64],
    q: NDArray[np.float64],
    mean: NDArray[np.float64],
    total: NDArray[np.float64],
    at_once: NDArray[np.float64],
    held: NDArray[np.float64],
) -> None:
    """March the elements and add their forces and derivatives in modal coordinates.

    ``x = X q`` and ``n = n0 + V q``; R and N take friction and load to the modes.
    """
    modes, samples = q.shape
    has_normal = np.any(V)
    x, n, friction = np.empty(samples), np.empty(samples), np.empty(samples)
    doing = np.empty(samples, dtype=np.int8)
    for e in range(len(X)):
        mu, preload = friction_coefficient[e], max(normal_load[e], 0.0)
        np.dot(X[e], q, x)
        n[:] = normal_load[e]
        if has_normal:
            n += np.dot(V[e], q)
        z, placed_at, placed_by = 0.0, 0, STICKS
        for i in range(samples):
            z, does = move_slider(x[i - 1], n[i - 1], x[i], n[i], mu, z)
            if does != STICKS:
                placed_at, placed_by = i, does
        for i in range(samples):
            z, doing[i] = move_slider(x[i - 1], n[i - 1], x[i], n[i], mu, z)
            friction[i] = x[i] - z
        for r in range(modes):
            for i in range(samples):
                total[r, i] += R[e, r] * friction[i]
            if has_normal:
                for i in range(samples):
                    total[r, i] += N[e, r] * (max(n[i], 0.0) - preload)
        begin = 0
        for end in range(1, samples + 1):
            does = doing[begin]
            if end < samples and doing[end] == does:
                continue
            slips = does in (SLIPS_NEGATIVE, SLIPS_POSITIVE)
            if does == CLOSES:
                placed_at, placed_by = begin, does
            if does != OPEN:
                of_x = 0.0 if slips else 1.0
                of_n = does * mu if slips else 0.0
                for r in range(modes):
                    for s in range(modes):
                        change = R[e, r] * (of_x * X[e, s] + of_n * V[e, s]) + N[e, r] * V[e, s]
                        at_once[begin, r, s] += change
                        at_once[end, r, s] -= change
                if not slips and placed_by != STICKS:
                    share, by_n_before, by_n = slider_placement(x, n, mu, placed_at, placed_by)
                    for r in range(modes):
                        for s in range(modes):
                            now = R[e, r] * (share * X[e, s] + by_n * V[e, s])
                            before = R[e, r] * ((1 - share) * X[e, s] + by_n_before * V[e, s])
                            for i in range(mean.shape[1]):
                                weight = mean[end, i] - mean[begin, i]
                                held[placed_at, r, s, i] -= now * weight
                                if placed_by == CLOSES:
                                    held[placed_at - 1, r, s, i] -= before * weight
            if slips:
                placed_at, placed_by = end - 1, does
            begin = end
