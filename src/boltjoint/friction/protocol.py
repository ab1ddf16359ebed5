"""Protocol of a friction law: harmonic forces, tangents and contact states by the motion.

A law that the contact pairs of a case or the regions of a joint can have is an ``ElementLaw``
(``friction.element_law``).

In compiled loops a law is its kernel: a function ``add_forces(elements, motion, force, tangent)``
that adds the forces of all ``Elements`` to ``force``, and their tangents to ``tangent`` unless that
is empty; motion, force and tangent are those of ``FrictionLaw.force_and_tangent``. Forces that are
followed by AFT are those of its ``ModalElements``.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cache, cached_property
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.compiled import address_of

Array = NDArray[np.float64]


class Elements(NamedTuple):
    """Arrays of the elements of a law.

    Attributes
    ----------
    indices
        By element, as a rule the point it acts on, shape (elements,).
    quantities
        What describes each element, shape (quantities, elements).
    table
        Empty, or whatever else the kernel needs.
    """

    indices: NDArray[np.int64]
    quantities: Array
    table: Array

    @classmethod
    def of(
        cls, indices: NDArray[np.int64], quantities: Sequence[Array], table: Array | None = None
    ) -> "Elements":
        """Copies of these arrays, as kernels are compiled for them."""
        table = np.zeros((0, 0)) if table is None else table
        # a law without elements has quantities too
        rows = np.array(quantities, float).reshape(len(quantities), -1)
        return cls(np.array(indices, np.int64), rows, np.array(table, float))


class Kernel(NamedTuple):
    """The compiled function that adds the forces of a law, and the elements that it is given."""

    add_forces: Callable
    elements: Elements


@cache
def address_of_kernel(add_forces: Callable) -> int:
    """Where compiled loops find the function that adds the forces of a law."""
    none = np.zeros((0, 2))
    elements = Elements.of(np.zeros(0, np.int64), [np.zeros(0)])
    return address_of(add_forces, elements, none, none, np.zeros((0, 2, 2)))


class HarmonicBasis(NamedTuple):
    """Components of motion and force: ``harmonic`` number and ``is_sine``, shape (components,).

    ``synthesis`` has their values at the samples, shape (components, samples); ``weight`` that of a
    sample in each; ``mean`` the sums of the weighted values up to a sample, (samples + 1,
    components).
    """

    harmonic: NDArray[np.int64]
    is_sine: NDArray[np.bool_]
    synthesis: Array
    weight: Array
    mean: Array


class ModalTangent(Protocol):
    """Derivative of harmonic forces in modal coordinates, evaluated when it is called."""

    def __call__(self, precision: type[np.floating] = np.float64) -> Array:
        """D force[i, r] / d amplitude[j, s], shape (components, modes, components, modes).

        Of sliders in single precision in half of the time, where that is enough.
        """

    def along(self, change: Array) -> Array:
        """Derivative of the forces along a change of the amplitudes, both (components, modes)."""


class ModalElements(Protocol):
    """Elements of a law in modal coordinates."""

    def force_and_tangent(
        self, basis: HarmonicBasis, amplitude: Array
    ) -> tuple[Array, ModalTangent]:
        """Harmonic forces in modal coordinates, and their lazily evaluated derivative.

        Parameters
        ----------
        basis
            The components of motion and force.
        amplitude
            Modal coordinates by component [kg^1/2 m], shape (components, modes).

        Returns
        -------
        force : ndarray
            Shape (components, modes) [kg^-1/2 N].
        tangent : ModalTangent
            Derivative of the forces by the amplitudes.
        """

    def delay(self, basis: HarmonicBasis, amplitude: Array) -> Array:
        """Derivative of the harmonic forces by the rate at which a change of the motion grows.

        Under a change ``exp(r t)`` times a periodic one, an element holds what the motion was at
        the times tau before at which sliders stopped: in the derivative of the forces each of these
        is multiplied by ``exp(-r tau)``. This is the derivative of that by r at r = 0, with r over
        a period.

        Parameters
        ----------
        basis, amplitude
            As for ``force_and_tangent``.

        Returns
        -------
        ndarray
            By the derivative of the forces [s^-2], shape (components, modes, components, modes).
            What rests for the whole period has no part in it.
        """


class FrictionLaw(ABC):
    """Friction elements on contact points, as functions of the harmonic motion of these points.

    ``force``, ``force_and_tangent`` and ``contact_state`` check the motion. Solvers, whose motions
    have the right shape by construction and may overflow, call ``evaluate`` and
    ``evaluate_with_tangent``, and give the frequency in rad/s.
    """

    if TYPE_CHECKING:
        # fields of some laws and properties of others

        @property
        def name(self) -> str:
            """The law in files."""

        @property
        def point_of_element(self) -> NDArray[np.int64]:
            """The contact point each element acts on, counted from 0, shape (elements,)."""

        @property
        def directions(self) -> tuple[str, ...]:
            """Directions of motion that the law needs."""

        @property
        def components(self) -> tuple[str, ...]:
            """Harmonic coefficients of the motion that the law needs."""

        @property
        def tangential_stiffness(self) -> Array:
            """Stiffness of each element in stick [N/m], shape (elements,)."""

        @property
        def slip_force(self) -> Array:
            """Force at which all of an element slips as assembled [N], shape (elements,)."""

        def stuck_stiffness(self, points: int) -> Array:
            """Stiffness of the points in stick [N/m], shape (points, directions)."""

    def force(self, motion: Array, frequency: float = 0.0) -> Array:
        """Harmonic forces of all elements on each point.

        Parameters
        ----------
        motion
            Coefficients of the displacements [m] in the order of ``components``, one direction
            after another, shape (points, directions * components).
        frequency
            Frequency of the motion [Hz], for laws that depend on it; at 0 it is so slow that no
            viscous force acts.

        Returns
        -------
        ndarray
            Coefficients of the friction force, then, where the law has a normal direction, of the
            excess of the normal load over that of the assembled state, which is in equilibrium [N],
            shape (points, directions * components).

        Raises
        ------
        ValueError
            If the motion is not of this shape, has fewer points than there are elements on, or is
            not finite, or if the frequency is negative.
        """
        return self.evaluate(self._checked(motion, self._columns), in_radians(frequency))

    def force_and_tangent(self, motion: Array, frequency: float = 0.0) -> tuple[Array, Array]:
        """Harmonic forces on each point and their derivative by the motion of that point.

        Parameters
        ----------
        motion, frequency
            As for ``force``.

        Returns
        -------
        force : ndarray
            As from ``force``.
        tangent : ndarray
            ``tangent[p, i, j]`` is d force_i / d motion_j [N/m], shape (points, directions *
            components, directions * components).

        Raises
        ------
        ValueError
            As for ``force``.
        """
        motion = self._checked(motion, self._columns)
        return self.evaluate_with_tangent(motion, in_radians(frequency))

    def contact_state(self, motion: Array, frequency: float = 0.0) -> NDArray[np.int8]:
        """State of every element over the period (``friction.contact_states``).

        An element that is open for a part of the period is in stick-slip with separation, whether
        or not it slips while it is closed.

        Parameters
        ----------
        motion, frequency
            As for ``force``.

        Raises
        ------
        ValueError
            As for ``force``.
        """
        return self.states(self._checked(motion, self._columns), in_radians(frequency))

    @property
    def kernel(self) -> Kernel | None:
        """The compiled function that adds the forces and its elements, None without one."""
        return None

    @abstractmethod
    def evaluate(self, motion: Array, w: float) -> Array:
        """As ``force``, without checks, at the frequency w [rad/s]."""

    @abstractmethod
    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """As ``force_and_tangent``, without checks, at the frequency w [rad/s]."""

    def frequency_derivative(self, motion: Array, w: float) -> Array | None:
        """Derivative of the forces by w, shape of the motion; None where they do not depend on it.

        Parameters
        ----------
        motion
            As for ``force``.
        w
            The frequency [rad/s].
        """
        return None

    def modal_force_and_tangent(
        self, rows: tuple[Array, ...], amplitude: Array, w: float
    ) -> tuple[Array, ModalTangent] | None:
        """Harmonic forces in modal coordinates and their derivative, without tangents of points.

        None of laws whose forces are those of ``evaluate`` alone.

        Parameters
        ----------
        rows
            Modal rows of the points in each direction [kg^-1/2], each (points, modes).
        amplitude
            Modal coordinates by component [kg^1/2 m], shape (components, modes).
        w
            The frequency [rad/s].
        """
        return None

    @abstractmethod
    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """As ``contact_state``, without checks, at the frequency w [rad/s]."""

    @cached_property
    def _points(self) -> int:
        """Number of points up to the last one with an element."""
        return int(self.point_of_element.max(initial=-1)) + 1

    @property
    def _columns(self) -> int:
        """Number of coefficients of the motion of a point."""
        return len(self.directions) * len(self.components)

    def _checked(self, motion: Array, columns: int) -> Array:
        motion = checks.array("motion", motion, ("points", columns))
        if len(motion) < self._points:
            raise ValueError(
                f"motion has {len(motion)} points, but there are elements on point "
                f"{self._points - 1}, counted from 0"
            )
        return motion


def in_radians(frequency: float) -> float:
    """A frequency in rad/s by that in Hz."""
    return 2 * np.pi * checks.number("frequency", frequency, at_least=0)
