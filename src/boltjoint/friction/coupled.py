"""Friction in both directions of the contact plane with a circular limit (Coulomb).

A spring of the stiffness k along both tangents of a point in series with a slider that is a point
in the contact plane: it sticks while the magnitude of the friction is below mu n, and else moves in
the direction of the friction, whose magnitude is mu n. There is no closed form of the harmonics of
an elliptic orbit: the forces are those of AFT (``coupled_kernels``).

On a circular orbit of radius A above mu n / k, under constant n, the slider follows on a circle of
radius ``B = sqrt(A^2 - (mu n / k)^2)``: its velocity has the direction of the friction, which so is
normal to the radius of the slider, and the spring is the other leg of a right triangle over A. The
friction has the constant magnitude mu n and leads the displacement by the angle ``acos(mu n / (k
A))``; a period dissipates ``2 pi mu n B``. On a straight orbit it is the law of one direction.

Integration in time shares no code with AFT, so that either verifies the other: a slider that slips
moves in the direction that the friction has in the middle of the step, which is found by the radial
return of half the step (a midpoint rule, of second order in the step).

References
----------
J. H. Griffin, C.-H. Menq: Friction damping of circular motion and its implications to vibration
control. Journal of Vibration and Acoustics 113 (1991) 225-229.
K. Y. Sanliturk, D. J. Ewins: Modelling two-dimensional friction contact and its application using
harmonic balance method. Journal of Sound and Vibration 193 (1996) 511-523.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.coupled_kernels import add_forces, find_slip
from boltjoint.friction.declarations import COUPLED_CONSTANT, COUPLED_VARIABLE, LawDeclaration
from boltjoint.friction.forms import AtSamples, InTime, Period
from boltjoint.friction.protocol import Array
from boltjoint.friction.slider_forms import states_of_period
from boltjoint.friction.variable import VariableLoad


@dataclass(frozen=True)
class _PlaneAtSamples(AtSamples):
    """Forces at samples of sliders that are followed until periodic.

    ``quantities`` has k_u, k_v, n0 and mu of each element, shape (4, elements).
    """

    point_of_element: NDArray[np.int64]
    quantities: Array

    def evaluate(self, motion: Array, period: Period, tangent: Array) -> Array:
        """As of ``AtSamples``."""
        motion, force, tables = np.ascontiguousarray(motion), np.zeros(motion.shape), period.tables
        sums = np.zeros_like(tangent)
        weight = np.tile(tables.weight, motion.shape[1] // tables.weight.size)
        of_elements = self.point_of_element, self.quantities
        add_forces(*of_elements, motion, tables.synthesis, force, sums)
        tangent += weight[:, None] * sums
        return force * weight

    def states(self, displacement: Array, w: float) -> NDArray[np.int8]:
        """As of ``AtSamples``."""
        slips = np.empty(self.point_of_element.size, bool)
        load = np.empty((slips.size, displacement.shape[2]))
        displacement = np.ascontiguousarray(displacement)
        find_slip(self.point_of_element, self.quantities, displacement, slips, load)
        return states_of_period(slips, load)


@dataclass(frozen=True)
class _PlaneInTime(InTime):
    """Forces of the same sliders, followed in time."""

    point_of_element: NDArray[np.int64]
    quantities: Array

    def evaluate(self, motion: Array, w: float, samples: int) -> Array:
        """As of ``InTime``."""
        return integrate_in_plane(self.point_of_element, self.quantities, motion, samples)


class _CircularLimit(ABC):
    """The forms that both laws have: sliders that move in the plane, and no closed form."""

    closed_form = None
    point_of_element: NDArray[np.int64]

    @property
    @abstractmethod
    def _in_plane(self) -> Array:
        """k_u, k_v, n0 and mu of each element, shape (4, elements)."""

    def sliders(self) -> None:
        """None: they do not move on lines."""
        return None

    @cached_property
    def at_samples(self) -> AtSamples:
        """Sliders in the plane."""
        return _PlaneAtSamples(self.point_of_element, self._in_plane)

    @cached_property
    def in_time(self) -> InTime:
        """Sliders in the plane."""
        return _PlaneInTime(self.point_of_element, self._in_plane)


@dataclass(frozen=True)
class CoupledConstantLoad(_CircularLimit, ConstantLoad):
    """Friction elements in both directions under constant normal load, with a circular limit.

    Parameters
    ----------
    point_of_element, tangential_stiffness, slip_force
        As of ``ConstantLoad``; the stiffness is the same in both directions.

    Raises
    ------
    ValueError
        As for ``ConstantLoad``.
    """

    declaration: ClassVar[LawDeclaration] = COUPLED_CONSTANT

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points in stick [N/m], shape (points, directions)."""
        return np.tile(super().stuck_stiffness(points), 2)

    @property
    def _in_plane(self) -> Array:
        k, limit = self.tangential_stiffness, self.slip_force
        return np.array([k, np.zeros_like(k), limit, np.ones_like(k)])


@dataclass(frozen=True)
class CoupledVariableLoad(_CircularLimit, VariableLoad):
    """Friction elements in both directions under variable normal load, with a circular limit.

    Parameters
    ----------
    point_of_element, tangential_stiffness, normal_stiffness, normal_load, friction_coefficient
        As of ``VariableLoad``; stiffness and friction coefficient are the same in both directions.

    Raises
    ------
    ValueError
        As for ``VariableLoad``.
    """

    declaration: ClassVar[LawDeclaration] = COUPLED_VARIABLE

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points with closed elements in stick [N/m], (points, directions)."""
        return super().stuck_stiffness(points)[:, [0, 0, 1]]

    @property
    def _in_plane(self) -> Array:
        return np.array([getattr(self, name) for name in self.quantities])


#: change of a slider over a period, relative to the largest limit, below which it is periodic, and
#: periods after which it counts as such, as in ``coupled_kernels``
_RETURN, _MOST_PERIODS = 1e-10, 1000


def integrate_in_plane(
    point: NDArray[np.int64], quantities: Array, motion: Array, samples: int
) -> Array:
    """Harmonic forces on points along t1, t2 and the normal, as ``forces_in_time``.

    Parameters
    ----------
    point
        Point of each element, shape (elements,).
    quantities
        k_u, k_v, n0 and mu of each, shape (4, elements).
    motion
        Bias, sine and cosine of the displacements along t1, t2 and the normal, shape (points, 9).
    samples
        Steps a period.
    """
    phase = 2 * np.pi * np.arange(samples) / samples
    table, middles = (
        np.column_stack([np.ones(samples), np.sin(phases), np.cos(phases)])
        for phases in (phase, phase + np.pi / samples)
    )
    force = np.zeros_like(motion)
    for p, (k_u, k_v, load, mu) in zip(point, quantities.T, strict=True):
        springs = np.array([k_u, k_u, k_v])
        x, x_middle = (
            springs * (phases @ motion[p].reshape(3, 3).T) for phases in (table, middles)
        )
        n, n_middle = load + x[:, 2], load + x_middle[:, 2]
        friction = np.zeros((samples, 2))
        _follow(x[:, :2].copy(), n, x_middle[:, :2].copy(), n_middle, mu, friction)
        change = np.maximum(n, 0.0) - max(load, 0.0)
        forces = np.column_stack([friction, change]).T @ table
        force[p] += (forces * [1 / samples, 2 / samples, 2 / samples]).ravel()
    return force


@kept_loop
def _follow(
    x: Array, n: Array, x_middle: Array, n_middle: Array, mu: float, friction: Array
) -> None:
    """Friction at the samples of the period in which the slider is periodic, (samples, 2)."""
    samples = len(x)
    z, e = np.zeros(2), np.zeros(2)
    smallest = _RETURN * mu * max(np.max(n), 0.0)
    for _ in range(_MOST_PERIODS):
        begin = z.copy()
        # a period ends at its first sample
        for i in range(1, samples + 1):
            at = i % samples
            if n[at] <= 0.0:
                z[:] = x[at]
                friction[at] = 0.0
                continue
            start = x[i - 1]
            halfway, half_limit = x_middle[i - 1], mu * max(n_middle[i - 1], 0.0)
            if n[i - 1] <= 0.0:
                # the slider restarts where the contact closes, by linear interpolation
                part = n[i - 1] / (n[i - 1] - n[at])
                z[:] = start + part * (x[at] - start)
                halfway, half_limit = 0.5 * (z + x[at]), 0.5 * mu * n[at]
            limit = mu * n[at]
            f = x[at] - z
            if f[0] * f[0] + f[1] * f[1] > limit * limit:
                e[:] = halfway - z
                size = np.sqrt(e[0] * e[0] + e[1] * e[1])
                if size > half_limit and half_limit > 0.0:
                    # the radial return moves the slider along the friction: its direction stays
                    e /= size
                else:
                    e[:] = f / np.sqrt(f[0] * f[0] + f[1] * f[1])
                # the slider moves by l along e, until the friction has the magnitude of the limit
                along = f[0] * e[0] + f[1] * e[1]
                beside = f[0] * e[1] - f[1] * e[0]
                if abs(beside) < limit:
                    moved = along - np.sqrt(limit * limit - beside * beside)
                else:
                    e[:] = f / np.sqrt(f[0] * f[0] + f[1] * f[1])
                    moved = np.sqrt(f[0] * f[0] + f[1] * f[1]) - limit
                z += moved * e
            friction[at] = x[at] - z
        change = z - begin
        if change[0] * change[0] + change[1] * change[1] <= smallest * smallest:
            break
