"""Friction beside a viscoelastic layer: a slider, and a spring with a dashpot (Kelvin-Voigt).

The layer between two surfaces, a polymer or a lubricant, is as wide as the contact and moves with
it whether that slips or not. Beside the spring and slider of ``friction.constant`` it has the force
``k_l u + d u'``, which depends on the frequency w of the motion: ``(k_l + i w d) u`` in its first
harmonic. A period dissipates ``pi w d A^2`` in it, at any amplitude A.

References
----------
D. I. G. Jones: Handbook of Viscoelastic Vibration Damping. Wiley, 2001: chapter 2.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction import constant
from boltjoint.friction.contact_states import STICK, STICK_SLIP
from boltjoint.friction.dashpot_forms import ClosedFormWithDashpots, Dashpots
from boltjoint.friction.declarations import KELVIN_VOIGT, LawDeclaration
from boltjoint.friction.element_law import Array, ContactPairs, ElementLaw, check_elements
from boltjoint.friction.forms import ClosedForm, CompiledForm
from boltjoint.friction.protocol import Elements, Kernel
from boltjoint.friction.sliders_at_samples import Sliders
from boltjoint.harmonics import Components

#: limit of the springs of the layer over that of the sliders beside them: they never slip
_NEVER = 1e100


@dataclass(frozen=True)
class KelvinVoigtLayer(ElementLaw):
    """Friction elements under constant normal load, each beside a spring with a dashpot.

    Parameters
    ----------
    point_of_element
        The contact point each element acts on, counted from 0, shape (elements,).
    tangential_stiffness
        k of each spring with a slider [N/m], shape (elements,).
    slip_force
        mu N of each slider [N], shape (elements,).
    layer_stiffness
        k_l of each layer [N/m], shape (elements,).
    layer_damping
        d of each layer [N s/m], shape (elements,).

    Raises
    ------
    ValueError
        If they differ in length, a point is no index, or a value is not positive and finite.
    """

    point_of_element: NDArray[np.int64]
    tangential_stiffness: Array
    slip_force: Array
    layer_stiffness: Array
    layer_damping: Array

    declaration: ClassVar[LawDeclaration] = KELVIN_VOIGT
    #: what describes each element, with unit and meaning
    quantities: ClassVar[dict[str, tuple[str, str]]] = {
        "tangential_stiffness": ("N/m", "tangential contact stiffness"),
        "slip_force": ("N", "friction coefficient times normal load"),
        "layer_stiffness": ("N/m", "stiffness of the layer beside the slider"),
        "layer_damping": ("N s/m", "viscous damping of the layer beside the slider"),
    }

    def __post_init__(self) -> None:
        """Refuse impossible elements."""
        check_elements(self)

    @classmethod
    def from_contact(  # type: ignore[override]  # keys are those of its declaration
        cls,
        pairs: ContactPairs,
        *,
        tangential_stiffness: float | Array,
        friction_coefficient: float | Array,
        layer_stiffness: float | Array,
        layer_damping: float | Array,
    ) -> tuple[Self, NDArray[np.int64]]:
        """Elements of the pairs that carry load: k, k_l [N/m], mu and d [N s/m], of all or each."""
        quantities = {
            "tangential_stiffness": tangential_stiffness,
            "friction_coefficient": friction_coefficient,
            "layer_stiffness": layer_stiffness,
            "layer_damping": layer_damping,
        }
        loaded = np.flatnonzero(pairs.normal_load > 0)
        of_pairs = (pairs.of_each(name, value, above=0) for name, value in quantities.items())
        k, mu, k_l, d = (values[loaded] for values in of_pairs)
        return cls(np.arange(loaded.size), k, mu * pairs.normal_load[loaded], k_l, d), loaded

    def stiffness_along(self, direction: str) -> Array:
        """Stiffness of each element in stick [N/m], that of its layer included."""
        return self.tangential_stiffness + self.layer_stiffness

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points in stick [N/m], shape (points, directions)."""
        points = checks.whole("points", points, at_least=self._points)
        stiffness = self.stiffness_along("tangential")
        total = np.bincount(self.point_of_element, stiffness, minlength=points)
        return np.asarray(total[:, None], dtype=np.float64)

    def sliders(self) -> Sliders:
        """The elements, then the springs of their layers, which never slip."""
        limit = np.append(self.slip_force, _NEVER * self.slip_force)
        return Sliders(
            element=np.tile(np.arange(self.slip_force.size), 2),
            point=np.tile(self.point_of_element, 2),
            tangential_stiffness=np.append(self.tangential_stiffness, self.layer_stiffness),
            normal_stiffness=None,
            normal_load=np.ones_like(limit),
            friction_coefficient=limit,
        )

    @cached_property
    def dashpots(self) -> Dashpots:
        """Those of the layers."""
        every = np.arange(self.layer_damping.size)
        return Dashpots(every, self.point_of_element, self.layer_damping)

    @cached_property
    def closed_form(self) -> ClosedForm:
        """The describing function of each element, with its dashpot."""
        sliders = self.sliders()
        springs = sliders.tangential_stiffness, sliders.friction_coefficient
        kernel = Kernel(constant.add_forces, Elements.of(sliders.point, springs))
        form = CompiledForm(kernel, self._states)
        return ClosedFormWithDashpots(form, self.dashpots, Components(self.components))

    def _states(self, motion: Array) -> NDArray[np.int8]:
        amplitude = np.hypot(motion[:, 0], motion[:, 1])[self.point_of_element]
        slips = self.tangential_stiffness * amplitude > self.slip_force
        return np.where(slips, STICK_SLIP, STICK).astype(np.int8)
