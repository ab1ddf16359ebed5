"""Friction under variable normal load: a slider between a tangential and a normal spring.

The normal motion loads and unloads the contact, up to separation. The analytic describing function
is in ``variable_kernels``, with its references.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.declarations import VARIABLE, LawDeclaration
from boltjoint.friction.element_law import Array, ContactPairs, ElementLaw, check_elements
from boltjoint.friction.forms import CompiledForm
from boltjoint.friction.protocol import Kernel
from boltjoint.friction.sliders_at_samples import Sliders
from boltjoint.friction.variable_kernels import add_forces, find_states


@dataclass(frozen=True)
class VariableLoad(ElementLaw):
    """Friction elements under variable normal load, any number of them on each contact point.

    With tangential displacement u and normal displacement v, positive when closing, the normal load
    is ``n = max(n0 + k_v v, 0)`` and the friction force ``f = k_u u - z``. The slider, at z / k_u,
    sticks while ``|f| < mu n`` and else slips with the bound that it has reached: z is a play
    between ``k_u u - mu n`` and ``k_u u + mu n``. In separation both bounds are k_u u.

    The slider starts without traction at the assembled state. This decides the residual traction of
    a contact that does not slip in the steady state: if a constant z lies between the bounds, it is
    the one nearest to zero. All other steady states do not depend on the start.

    Parameters
    ----------
    point_of_element
        The contact point each element acts on, counted from 0, shape (elements,).
    tangential_stiffness, normal_stiffness
        k_u and k_v of each element [N/m], shape (elements,).
    normal_load
        n0 of each element [N], shape (elements,); negative for a gap, of ``-n0 / k_v``.
    friction_coefficient
        mu of each element [-], shape (elements,).

    Raises
    ------
    ValueError
        If they differ in length, a point is no index, a stiffness or mu is not positive and finite,
        or a load is not finite.
    """

    point_of_element: NDArray[np.int64]
    tangential_stiffness: Array
    normal_stiffness: Array
    normal_load: Array
    friction_coefficient: Array

    declaration: ClassVar[LawDeclaration] = VARIABLE
    #: what describes each element, with unit and meaning
    quantities: ClassVar[dict[str, tuple[str, str]]] = {
        "tangential_stiffness": ("N/m", "tangential contact stiffness"),
        "normal_stiffness": ("N/m", "normal contact stiffness"),
        "normal_load": ("N", "normal load of the assembled state, negative for a gap"),
        "friction_coefficient": ("1", "friction coefficient"),
    }

    def __post_init__(self) -> None:
        """Refuse impossible friction elements."""
        check_elements(self, {"normal_load": {}})

    @classmethod
    def from_contact(  # type: ignore[override]  # keys are those of its declaration
        cls,
        pairs: ContactPairs,
        *,
        tangential_stiffness: float | Array,
        friction_coefficient: float | Array,
        normal_stiffness: float | Array,
    ) -> tuple[Self, NDArray[np.int64]]:
        """Elements of all pairs: k_u and k_v [N/m], and mu, of all or of each.

        The load of an open one is ``-k_v gap`` (eq. 3.4), so that it may close.
        """
        k_u = pairs.of_each("tangential_stiffness", tangential_stiffness, above=0)
        mu = pairs.of_each("friction_coefficient", friction_coefficient, above=0)
        k_v = pairs.of_each("normal_stiffness", normal_stiffness, above=0)
        every = np.arange(pairs.normal_load.size)
        elements = cls(
            point_of_element=every,
            tangential_stiffness=k_u,
            normal_stiffness=k_v,
            normal_load=pairs.normal_load - k_v * pairs.gap,
            friction_coefficient=mu,
        )
        return elements, every

    @property
    def slip_force(self) -> Array:
        """Mu n0 of each element in the assembled state [N], 0 where it is open."""
        return self.friction_coefficient * np.maximum(self.normal_load, 0.0)

    @cached_property
    def closed_form(self) -> CompiledForm | None:
        """Harmonics of the pieces of a period.

        The normal force is the excess of the normal load over ``max(n0, 0)``.
        """
        return CompiledForm(Kernel(add_forces, self.compiled_elements), self._states)

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points with closed elements in stick [N/m], (points, directions)."""
        points = checks.whole("points", points, at_least=self._points)
        closed = self.normal_load > 0
        return np.column_stack(
            [
                np.bincount(self.point_of_element, stiffness * closed, minlength=points)
                for stiffness in (self.tangential_stiffness, self.normal_stiffness)
            ]
        )

    def sliders(self) -> Sliders | None:
        """The elements themselves."""
        return self._on_lines()

    def _on_lines(self) -> Sliders:
        return Sliders(
            np.arange(self.point_of_element.size),
            self.point_of_element,
            self.tangential_stiffness,
            self.normal_stiffness,
            self.normal_load,
            self.friction_coefficient,
        )

    def _states(self, motion: Array) -> NDArray[np.int8]:
        state = np.empty(self.point_of_element.size, dtype=np.int8)
        find_states(self.compiled_elements, motion, state)
        return state

    def replaced_by(
        self, point_of_element: NDArray[np.int64], tangential_stiffness: Array, slip_force: Array
    ) -> Self:
        """Other elements on the same points, by stiffness [N/m] and slip force [N] of each.

        On every point the ratios of k_v to k_u and n0 to mu n0 stay those of its closed elements.
        """
        new = checks.indices(
            "point_of_element", point_of_element, ("elements",), count=self._points
        )
        closed = self.normal_load > 0
        sums = [
            np.bincount(self.point_of_element, values * closed)[new]
            for values in (
                self.tangential_stiffness,
                self.normal_stiffness,
                self.normal_load,
                self.slip_force,
            )
        ]
        return type(self)(
            point_of_element=point_of_element,
            tangential_stiffness=tangential_stiffness,
            normal_stiffness=tangential_stiffness * sums[1] / sums[0],
            normal_load=slip_force * sums[2] / sums[3],
            friction_coefficient=sums[3] / sums[2],
        )
