"""Protocol of a friction law: harmonic forces, tangents and contact states by the motion."""

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

Array = NDArray[np.float64]


class FrictionLaw(ABC):
    """Friction elements on contact points, as functions of the harmonic motion of these points.

    ``force``, ``force_and_tangent`` and ``contact_state`` check the motion. Solvers, whose motions
    have the right shape by construction and may overflow, call ``evaluate`` and
    ``evaluate_with_tangent``.
    """

    #: the contact point each element acts on, counted from 0
    point_of_element: NDArray[np.int64]
    #: directions of motion that the law needs
    directions: tuple[str, ...]
    #: harmonic coefficients of the motion that the law needs
    components: tuple[str, ...]

    def force(self, motion: Array) -> Array:
        """Harmonic forces of all elements on each point.

        Parameters
        ----------
        motion
            Coefficients of the displacements [m] in the order of ``components``, one direction
            after another, shape (points, directions * components).

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
            not finite.
        """
        return self.evaluate(self._checked(motion))

    def force_and_tangent(self, motion: Array) -> tuple[Array, Array]:
        """Harmonic forces on each point and their derivative by the motion of that point.

        Parameters
        ----------
        motion
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
        return self.evaluate_with_tangent(self._checked(motion))

    def contact_state(self, motion: Array) -> NDArray[np.int8]:
        """State of every element over the period (``friction.contact_states``).

        An element that is open for a part of the period is in stick-slip with separation, whether
        or not it slips while it is closed.

        Parameters
        ----------
        motion
            As for ``force``.

        Raises
        ------
        ValueError
            As for ``force``.
        """
        return self._states(self._checked(motion))

    @abstractmethod
    def evaluate(self, motion: Array) -> Array:
        """As ``force``, without checks."""

    @abstractmethod
    def evaluate_with_tangent(self, motion: Array) -> tuple[Array, Array]:
        """As ``force_and_tangent``, without checks."""

    @abstractmethod
    def _states(self, motion: Array) -> NDArray[np.int8]:
        """As ``contact_state``, without checks."""

    @cached_property
    def _points(self) -> int:
        """Number of points up to the last one with an element."""
        return int(self.point_of_element.max(initial=-1)) + 1

    def _checked(self, motion: Array) -> Array:
        columns = len(self.directions) * len(self.components)
        found = checks.array("motion", motion, ("points", columns))
        if len(found) < self._points:
            raise ValueError(
                f"motion has {len(found)} points, but there are elements on point "
                f"{self._points - 1}, counted from 0"
            )
        return found


def check_elements(law: FrictionLaw, signed: tuple[str, ...] = ()) -> None:
    """Convert the quantities of the elements of a new law to arrays of one length.

    Parameters
    ----------
    law
        A frozen dataclass during its construction.
    signed
        Names of ``quantities`` that may be negative.

    Raises
    ------
    ValueError
        If one is not an array of finite numbers, not positive, or of another length.
    """
    on = checks.indices("point_of_element", law.point_of_element, ("elements",))
    object.__setattr__(law, "point_of_element", on)
    for name in law.quantities:
        limits = {} if name in signed else {"above": 0}
        found = checks.array(name, getattr(law, name), on.shape, **limits)
        object.__setattr__(law, name, found)
