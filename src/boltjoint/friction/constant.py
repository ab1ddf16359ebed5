"""Friction under constant normal load: analytic describing function of Jenkins elements.

A spring of stiffness k in series with a slider that slips at mu N, under the displacement
``u = s sin(wt) + c cos(wt)``. The slider starts without traction at the assembled state, so an
element that does not slip is a spring; the steady hysteresis loop of one that slips does not depend
on the start (eq. 2.25 of the thesis).

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: section 2.2.1.
"""

from dataclasses import dataclass
from functools import cached_property
from math import atan2, pi, sqrt
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.compiled import kept_loop, loop
from boltjoint.friction.contact_states import STICK, STICK_SLIP
from boltjoint.friction.declarations import CONSTANT, LawDeclaration
from boltjoint.friction.element_law import Array, ContactPairs, ElementLaw, check_elements
from boltjoint.friction.forms import CompiledForm
from boltjoint.friction.protocol import Elements, Kernel
from boltjoint.friction.sliders_at_samples import Sliders


@dataclass(frozen=True)
class ConstantLoad(ElementLaw):
    """Friction elements under constant normal load, any number of them on each contact point.

    Parameters
    ----------
    point_of_element
        The contact point each element acts on, counted from 0, shape (elements,).
    tangential_stiffness
        k of each element [N/m], shape (elements,).
    slip_force
        mu N of each element [N], shape (elements,).

    Raises
    ------
    ValueError
        If the three differ in length, a point is no index, or a stiffness or slip force is not
        positive and finite.
    """

    point_of_element: NDArray[np.int64]
    tangential_stiffness: Array
    slip_force: Array

    declaration: ClassVar[LawDeclaration] = CONSTANT
    #: what describes each element, with unit and meaning
    quantities: ClassVar[dict[str, tuple[str, str]]] = {
        "tangential_stiffness": ("N/m", "tangential contact stiffness"),
        "slip_force": ("N", "friction coefficient times normal load"),
    }

    def __post_init__(self) -> None:
        """Refuse impossible friction elements."""
        check_elements(self)

    @classmethod
    def from_contact(  # type: ignore[override]  # keys are those of its declaration
        cls,
        pairs: ContactPairs,
        *,
        tangential_stiffness: float | Array,
        friction_coefficient: float | Array,
    ) -> tuple[Self, NDArray[np.int64]]:
        """Elements of the pairs that carry load: k [N/m] and mu, of all or of each."""
        k = pairs.of_each("tangential_stiffness", tangential_stiffness, above=0)
        mu = pairs.of_each("friction_coefficient", friction_coefficient, above=0)
        loaded = np.flatnonzero(pairs.normal_load > 0)
        slip_force = mu[loaded] * pairs.normal_load[loaded]
        return cls(np.arange(loaded.size), k[loaded], slip_force), loaded

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points in stick [N/m], shape (points, directions)."""
        points = checks.whole("points", points, at_least=self._points)
        total = np.bincount(self.point_of_element, self.tangential_stiffness, minlength=points)
        return np.asarray(total[:, None], dtype=np.float64)

    @cached_property
    def closed_form(self) -> CompiledForm | None:
        """The describing function of each element."""
        return CompiledForm(Kernel(add_forces, self.compiled_elements), self._states)

    def sliders(self) -> Sliders | None:
        """The elements themselves."""
        return self._on_lines()

    def _on_lines(self) -> Sliders:
        return Sliders(
            element=np.arange(self.slip_force.size),
            point=self.point_of_element,
            tangential_stiffness=self.tangential_stiffness,
            normal_stiffness=None,
            # only mu n is needed where n is constant
            normal_load=np.ones_like(self.slip_force),
            friction_coefficient=self.slip_force,
        )

    def _states(self, motion: Array) -> NDArray[np.int8]:
        amplitude = np.hypot(motion[:, 0], motion[:, 1])[self.point_of_element]
        slips = self.tangential_stiffness * amplitude > self.slip_force
        return np.where(slips, STICK_SLIP, STICK).astype(np.int8)

    def replaced_by(
        self, point_of_element: NDArray[np.int64], tangential_stiffness: Array, slip_force: Array
    ) -> "ConstantLoad":
        """Other elements on the same points, by stiffness [N/m] and slip force [N] of each."""
        return type(self)(point_of_element, tangential_stiffness, slip_force)


@loop
def _describing_function(k: float, slip: float, amplitude: float) -> tuple[float, float, float]:
    """In-phase and quadrature stiffness of an element in stick-slip, and sine of its slip angle.

    The element sticks from a reversal until the phase theta with cos(theta) = 1 - 2 mu N / (k A)
    (eq. 2.21, 2.23 counted from the reversal). The Fourier integrals (2.5, 2.6) over the loop
    (2.25) give k/pi (theta - sin theta cos theta) in phase with u, and, in phase with its
    velocity, 4 mu N (1 - mu N / (k A)) / (pi A): the loop's area over pi A^2.
    """
    ratio = slip / (k * amplitude)
    cosine = 1.0 - 2.0 * ratio
    sine = 2.0 * sqrt(ratio * (1.0 - ratio))
    theta = 2.0 * atan2(sqrt(ratio), sqrt(1.0 - ratio))  # acos(cosine), exact to rounding
    in_phase = k / pi * (theta - sine * cosine)
    quadrature = 4.0 * k / pi * ratio * (1.0 - ratio)
    return in_phase, quadrature, sine


@kept_loop
def add_forces(elements: Elements, motion: Array, force: Array, tangent: Array) -> None:
    """Add the forces of all elements, and the tangents where their array is not empty."""
    point_of_element, quantities, _ = elements
    stiffness, slip_force = quantities[0], quantities[1]
    with_tangent = tangent.size > 0
    for e in range(point_of_element.size):
        p = point_of_element[e]
        k, slip = stiffness[e], slip_force[e]
        s, c = motion[p, 0], motion[p, 1]
        square = s * s + c * c
        if k * k * square <= slip * slip:
            force[p, 0] += k * s
            force[p, 1] += k * c
            if with_tangent:
                tangent[p, 0, 0] += k
                tangent[p, 1, 1] += k
        else:
            amplitude = sqrt(square)
            real, imag, sine = _describing_function(k, slip, amplitude)
            force[p, 0] += real * s - imag * c
            force[p, 1] += real * c + imag * s
            if not with_tangent:
                continue
            # f = D'(A) q + D''(A) Jq with J a quarter turn, so
            # df = D' dq + D'' J dq + (dD'/dA q + dD''/dA Jq) dA, where A dA = q . dq
            ratio = slip / (k * amplitude)
            d_real = -4.0 * k / pi * ratio * sine / square
            d_imag = 4.0 * k / pi * ratio * (2.0 * ratio - 1.0) / square
            g_s = d_real * s - d_imag * c
            g_c = d_real * c + d_imag * s
            tangent[p, 0, 0] += real + g_s * s
            tangent[p, 0, 1] += -imag + g_s * c
            tangent[p, 1, 0] += imag + g_c * s
            tangent[p, 1, 1] += real + g_c * c
