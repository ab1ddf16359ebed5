"""Protocol of a friction law: harmonic forces, tangents and contact states by the motion.

A law that the contact pairs of a case or the regions of a joint can have is an ``ElementLaw``
(``friction.element_law``).
"""

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.kernels import Kernel
from boltjoint.friction.modal_elements import ModalTangent

Array = NDArray[np.float64]


class FrictionLaw(ABC):
    """Friction elements on contact points, as functions of the harmonic motion of these points.

    ``force``, ``force_and_tangent`` and ``contact_state`` check the motion. Solvers, whose motions
    have the right shape by construction and may overflow, call ``evaluate`` and
    ``evaluate_with_tangent``, and give the frequency in rad/s.
    """

    #: the contact point each element acts on, counted from 0
    point_of_element: NDArray[np.int64]
    #: directions of motion that the law needs
    directions: tuple[str, ...]
    #: harmonic coefficients of the motion that the law needs
    components: tuple[str, ...]

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
