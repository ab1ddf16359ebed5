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

References
----------
J. H. Griffin, C.-H. Menq: Friction damping of circular motion and its implications to vibration
control. Journal of Vibration and Acoustics 113 (1991) 225-229.
K. Y. Sanliturk, D. J. Ewins: Modelling two-dimensional friction contact and its application using
harmonic balance method. Journal of Sound and Vibration 193 (1996) 511-523.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NoReturn

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.aft_kernels import SampleTables
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.coupled_in_time import integrate_in_plane
from boltjoint.friction.coupled_kernels import add_forces, find_slip
from boltjoint.friction.declarations import COUPLED_CONSTANT, COUPLED_VARIABLE, LawDeclaration
from boltjoint.friction.law import Array, ElementLaw, Sliders, states_of_period
from boltjoint.friction.variable import VariableLoad


class _CircularLimit(ElementLaw):
    """What both laws have in common: elements whose sliders move in the plane."""

    has_sliders: ClassVar[bool] = False

    @property
    def _in_plane(self) -> Sequence[Array]:
        """k_u, k_v, n0 and mu of each element; zero, the slip force and 1 where n is constant."""
        raise NotImplementedError

    @cached_property
    def _quantities(self) -> Array:
        return np.array([np.broadcast_to(each, self.slip_force.shape) for each in self._in_plane])

    @property
    def kernel(self) -> None:
        """None: there is no closed form."""
        return None

    def sliders(self) -> Sliders:
        """Refused: the sliders do not move on lines.

        Raises
        ------
        ValueError
            Always.
        """
        raise ValueError(f"the law {self.name!r} has no sliders on lines: they move in the plane")

    def evaluate(self, motion: Array) -> Array:
        """Refused: there is no closed form.

        Raises
        ------
        ValueError
            Always.
        """
        self._refuse()

    def evaluate_with_tangent(self, motion: Array) -> tuple[Array, Array]:
        """Refused, as ``evaluate``."""
        self._refuse()

    def _states(self, motion: Array) -> NDArray[np.int8]:
        self._refuse()

    def _refuse(self) -> NoReturn:
        raise ValueError(
            f"the law {self.name!r} has no closed form: evaluate it by AFT (friction_force: aft)"
        )

    def evaluate_at_samples(self, motion: Array, tables: SampleTables, tangent: Array) -> Array:
        """Harmonic forces by samples of a period, of sliders that are followed until periodic."""
        motion, force = np.ascontiguousarray(motion), np.zeros(motion.shape)
        sums, weight = np.zeros_like(tangent), np.tile(tables.weight, len(self.directions))
        of_elements = self.point_of_element, self._quantities
        add_forces(*of_elements, motion, tables.synthesis, force, sums)
        tangent += weight[:, None] * sums
        return force * weight

    def states_at_samples(self, displacement: Array) -> NDArray[np.int8]:
        """State of each element over a period of samples."""
        slips = np.empty(self.slip_force.size, bool)
        load = np.empty((slips.size, displacement.shape[2]))
        displacement = np.ascontiguousarray(displacement)
        find_slip(self.point_of_element, self._quantities, displacement, slips, load)
        return states_of_period(slips, load)

    def evaluate_in_time(self, motion: Array, samples: int) -> Array:
        """As of any law, of sliders that move in the plane."""
        return integrate_in_plane(self.point_of_element, self._quantities, motion, samples)


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
        return np.tile(ConstantLoad.stuck_stiffness(self, points), 2)

    @property
    def _in_plane(self) -> Sequence[Array]:
        return self.tangential_stiffness, 0.0, self.slip_force, 1.0


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
        return VariableLoad.stuck_stiffness(self, points)[:, [0, 0, 1]]

    @property
    def _in_plane(self) -> Sequence[Array]:
        return [getattr(self, name) for name in self.quantities]
