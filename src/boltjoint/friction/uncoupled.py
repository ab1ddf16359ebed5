"""Friction in both directions of the contact plane, uncoupled: an element along each axis.

Motion along both tangents of a point, the bar and its width in a half lap, each drives an element
of their own (``friction.constant``, ``friction.variable``), as if the limit of the friction force
were a square in place of Coulomb's circle. The forces keep their closed forms; but along a diagonal
of the axes the slip force is too large by a factor of sqrt(2), and a point on a circular orbit
sticks twice in every period where it always slips.

References
----------
C.-H. Menq, P. Chidamparam, J. H. Griffin: Friction damping of two-dimensional motion and its
application in vibration control. Journal of Sound and Vibration 144 (1991) 427-447.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop
from boltjoint.friction import constant, variable_kernels
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.declarations import UNCOUPLED_CONSTANT, UNCOUPLED_VARIABLE, LawDeclaration
from boltjoint.friction.forms import CompiledForm
from boltjoint.friction.protocol import Array, Elements, Kernel
from boltjoint.friction.sliders_at_samples import Sliders
from boltjoint.friction.variable import VariableLoad


@dataclass(frozen=True)
class UncoupledConstantLoad(ConstantLoad):
    """Two friction elements under constant normal load, along t1 and along t2, for each of these.

    Parameters
    ----------
    point_of_element, tangential_stiffness, slip_force
        As of ``ConstantLoad``; both directions have the same stiffness and slip force.

    Raises
    ------
    ValueError
        As for ``ConstantLoad``.
    """

    declaration: ClassVar[LawDeclaration] = UNCOUPLED_CONSTANT

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points in stick [N/m], shape (points, directions)."""
        return np.tile(super().stuck_stiffness(points), 2)

    def sliders(self) -> Sliders:
        """The elements along t1, then those along t2."""
        return _in_both_directions(self._on_lines())

    def _states(self, motion: Array) -> NDArray[np.int8]:
        return np.maximum(super()._states(motion[:, :2]), super()._states(motion[:, 2:]))

    @cached_property
    def closed_form(self) -> CompiledForm:
        """That of one direction, along both."""
        return CompiledForm(
            Kernel(_add_forces_of_constant_load, self.compiled_elements), self._states
        )


@dataclass(frozen=True)
class UncoupledVariableLoad(VariableLoad):
    """Two friction elements, along t1 and along t2, with one normal spring, for each of these.

    Both have the normal load of this spring, which acts on the structure once.

    Parameters
    ----------
    point_of_element, tangential_stiffness, normal_stiffness, normal_load, friction_coefficient
        As of ``VariableLoad``; both directions have the same stiffness and friction coefficient.

    Raises
    ------
    ValueError
        As for ``VariableLoad``.
    """

    declaration: ClassVar[LawDeclaration] = UNCOUPLED_VARIABLE

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points with closed elements in stick [N/m], (points, directions)."""
        return super().stuck_stiffness(points)[:, [0, 0, 1]]

    def sliders(self) -> Sliders:
        """The elements along t1, then those along t2."""
        return _in_both_directions(self._on_lines())

    def _states(self, motion: Array) -> NDArray[np.int8]:
        # of a separation both know
        along_t1, along_t2 = (np.hstack([motion[:, at : at + 3], motion[:, 6:]]) for at in (0, 3))
        return np.maximum(super()._states(along_t1), super()._states(along_t2))

    @cached_property
    def closed_form(self) -> CompiledForm:
        """That of one direction, along both."""
        return CompiledForm(
            Kernel(_add_forces_of_variable_load, self.compiled_elements), self._states
        )


def _in_both_directions(sliders: Sliders) -> Sliders:
    """The same sliders along t1 and along t2."""
    k_v = sliders.normal_stiffness
    return Sliders(
        element=np.tile(sliders.element, 2),
        point=np.tile(sliders.point, 2),
        tangential_stiffness=np.tile(sliders.tangential_stiffness, 2),
        normal_stiffness=None if k_v is None else np.tile(k_v, 2),
        normal_load=np.tile(sliders.normal_load, 2),
        friction_coefficient=np.tile(sliders.friction_coefficient, 2),
        lateral=np.repeat([False, True], sliders.point.size),
    )


@kept_loop
def _add_forces_of_constant_load(
    elements: Elements, motion: Array, force: Array, tangent: Array
) -> None:
    """Add the forces of all elements, and the tangents where their array is not empty."""
    for at in (0, 2):
        of_direction = slice(at, at + 2)
        constant.add_forces(
            elements,
            motion[:, of_direction],
            force[:, of_direction],
            tangent[:, of_direction, of_direction],
        )


@kept_loop
def _add_forces_of_variable_load(
    elements: Elements, motion: Array, force: Array, tangent: Array
) -> None:
    """Add the forces of all elements, and the tangents where their array is not empty."""
    points = len(motion)
    some_motion, some_force = np.empty((points, 6)), np.empty((points, 6))
    some_tangent = np.empty((len(tangent), 6, 6))
    some_motion[:, 3:] = motion[:, 6:]
    for at in (0, 3):
        some_motion[:, :3] = motion[:, at : at + 3]
        some_force[:] = 0.0
        some_tangent[:] = 0.0
        variable_kernels.add_forces(elements, some_motion, some_force, some_tangent)
        force[:, at : at + 3] += some_force[:, :3]
        tangent[:, at : at + 3, at : at + 3] += some_tangent[:, :3, :3]
        tangent[:, at : at + 3, 6:] += some_tangent[:, :3, 3:]
        if at == 0:  # both have the normal load in common, and it acts once
            force[:, 6:] += some_force[:, 3:]
            tangent[:, 6:, 6:] += some_tangent[:, 3:, 3:]
