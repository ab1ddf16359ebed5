"""Four-parameter Iwan elements: analytic describing function, loading curve and rule in time.

An element is a continuous distribution of springs with sliders in parallel, which slip at the
displacements phi with the density (Segalman 2005, eq. 21)::

    rho(phi) = R phi^chi (0 < phi < phi_max)  +  S delta(phi - phi_max)

of stiffness K_T and slip force F_S, with ``beta = S (chi + 1) / (R phi_max^(chi + 1))``. Up to
phi_max (microslip) its dissipation grows with the amplitude to the power 3 + chi; from there all of
it slips. Some of it slips at any amplitude: it sticks at rest only.

With ``x = phi_max / A``, ``K_p = K_T / (1 + beta)`` and the describing function f(x) of a spring
with a slider (``friction.constant``), integration by parts of the sum over all phi gives the
stiffness ``K_T f(x) - 8/pi K_p x^-(chi + 1) B_x(chi + 5/2, 3/2)``, with the incomplete beta
function, for x < 1 and the same with the complete one and f = 1 for x > 1.

References
----------
D. J. Segalman: A four-parameter Iwan model for lap-type joints. Journal of Applied Mechanics 72
(2005) 752-760.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, exp, hypot, lgamma, pi, sqrt
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.compiled import kept_loop, loop
from boltjoint.friction.contact_states import STICK, STICK_SLIP
from boltjoint.friction.declarations import IWAN, LawDeclaration
from boltjoint.friction.element_law import Array, ContactPairs, ElementLaw, check_elements
from boltjoint.friction.forms import AtSamples, CompiledForm, InTime, Period
from boltjoint.friction.iwan_at_samples import Hysteresis, ModalIwan
from boltjoint.friction.protocol import Elements, Kernel, ModalElements
from boltjoint.friction.sliders_at_samples import Sliders

#: terms after which a series in x or 1 - x, at most 1/2, has converged to rounding
_TERMS = 52
#: term that changes no digit of a series, whose sums are above 0.1
_NO_TERM = 1e-18

#: smallest slip displacement over phi_max of the sliders that stand for an element
_SMALLEST = 1e-6


@dataclass(frozen=True)
class FourParameterIwan(ElementLaw):
    """Four-parameter Iwan elements, any number of them on each contact point.

    Parameters
    ----------
    point_of_element
        The contact point each element acts on, counted from 0, shape (elements,).
    tangential_stiffness
        K_T of each element [N/m], shape (elements,).
    slip_force
        F_S of each element [N], shape (elements,).
    chi
        Exponent of the distribution, above -1 and at most 0, shape (elements,).
    beta
        Stiffness of the sliders that slip at phi_max over that of all others, not negative, shape
        (elements,).

    Raises
    ------
    ValueError
        If they differ in length, a point is no index, or a value is out of its range.
    """

    point_of_element: NDArray[np.int64]
    tangential_stiffness: Array
    slip_force: Array
    chi: Array
    beta: Array

    declaration: ClassVar[LawDeclaration] = IWAN
    #: what describes each element, with unit and meaning
    quantities: ClassVar[dict[str, tuple[str, str]]] = {
        "tangential_stiffness": ("N/m", "tangential stiffness K_T at rest"),
        "slip_force": ("N", "force F_S in full slip"),
        "chi": ("1", "exponent of the distribution of slip displacements"),
        "beta": ("1", "stiffness that slips at phi_max over that which slips before"),
    }

    def __post_init__(self) -> None:
        """Refuse impossible elements."""
        check_elements(self, {"chi": {"above": -1, "at_most": 0}, "beta": {"at_least": 0}})

    @classmethod
    def from_contact(  # type: ignore[override]  # keys are those of its declaration
        cls,
        pairs: ContactPairs,
        *,
        tangential_stiffness: float | Array,
        friction_coefficient: float | Array,
        chi: float | Array,
        beta: float | Array,
    ) -> tuple[Self, NDArray[np.int64]]:
        """Elements of the pairs that carry load: K_T [N/m], F_S over the load, chi and beta.

        All may be those of each pair.
        """
        stiffness = pairs.of_each("tangential_stiffness", tangential_stiffness, above=0)
        mu = pairs.of_each("friction_coefficient", friction_coefficient, above=0)
        loaded = np.flatnonzero(pairs.normal_load > 0)
        like = stiffness[loaded], mu[loaded] * pairs.normal_load[loaded]
        shapes = (
            pairs.of_each(name, value)[loaded] for name, value in (("chi", chi), ("beta", beta))
        )
        return cls(np.arange(loaded.size), *like, *shapes), loaded

    @cached_property
    def largest_slip_displacement(self) -> Array:
        """phi_max of each element [m]: all of it slips where the amplitude is larger."""
        share = self.beta + (self.chi + 1) / (self.chi + 2)
        return self.slip_force * (1 + self.beta) / (self.tangential_stiffness * share)

    def loading_curve(self, displacement: Array) -> Array:
        """Force on first loading of each element alone [N], shape (..., elements)."""
        part = np.minimum(displacement[..., None] / self.largest_slip_displacement, 1.0)
        stiffness = self.tangential_stiffness - self._power_law_stiffness * part ** (
            self.chi + 1
        ) / (self.chi + 2)
        return stiffness * part * self.largest_slip_displacement

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points at rest [N/m], shape (points, directions)."""
        points = checks.whole("points", points, at_least=self._points)
        total = np.bincount(self.point_of_element, self.tangential_stiffness, minlength=points)
        return np.asarray(total[:, None], dtype=np.float64)

    def sliders(self, ratio: float = 1.02) -> Sliders:
        """Sliders that stand for the distribution, with the same stiffness and slip force.

        Time integration follows the law by them; AFT needs none. Each stands for the part of the
        distribution between two displacements of this ratio, from a millionth of phi_max on: 700 by
        default. At amplitudes above a thousandth of phi_max the force on first loading errs by up
        to 0.23, the dissipation by up to 0.65 times the square of the logarithm of the ratio: by
        9e-5 and 2.6e-4 by default.
        """
        ratio = checks.number("ratio", ratio, above=1)
        count = int(np.ceil(-np.log(_SMALLEST) / np.log(ratio)))
        cut = np.append(0.0, np.geomspace(_SMALLEST, 1.0, count))[:, None]
        stiffness = np.diff(cut ** (self.chi + 1), axis=0)
        moment = np.diff(cut ** (self.chi + 2), axis=0) * (self.chi + 1) / (self.chi + 2)
        k, s = (self._power_law_stiffness * np.vstack([e, self.beta]) for e in (stiffness, moment))
        s = s * self.largest_slip_displacement
        element = np.tile(np.arange(self.slip_force.size), len(k))
        # no slider is needed where beta is 0
        kept = k.ravel() > 0
        return Sliders(
            element=element[kept],
            point=self.point_of_element[element[kept]],
            tangential_stiffness=k.ravel()[kept],
            normal_stiffness=None,
            normal_load=np.ones(np.count_nonzero(kept)),
            friction_coefficient=s.ravel()[kept],
        )

    @cached_property
    def closed_form(self) -> CompiledForm:
        """The describing function of the distribution."""
        return CompiledForm(Kernel(_add_forces, self.compiled_elements), self._states)

    @cached_property
    def at_samples(self) -> AtSamples:
        """Masing's rule."""
        return _MasingAtSamples(self.point_of_element, self.compiled_elements.quantities)

    @cached_property
    def in_time(self) -> InTime:
        """Masing's rule with a memory of the reversals: exact at the samples."""
        return _MasingInTime(self.point_of_element, self.compiled_elements.quantities)

    def _states(self, motion: Array) -> NDArray[np.int8]:
        return _states_by(np.any(motion, axis=1)[self.point_of_element])

    @cached_property
    def _power_law_stiffness(self) -> Array:
        """K_p: stiffness of all sliders but those that slip at phi_max [N/m]."""
        return self.tangential_stiffness / (1 + self.beta)

    @cached_property
    def compiled_elements(self) -> Elements:
        """By element K_p, phi_max, chi, beta and B(chi + 5/2, 3/2)."""
        complete = np.array([_complete_beta(chi + 2.5) for chi in self.chi])
        of_element = self._power_law_stiffness, self.largest_slip_displacement
        return Elements.of(self.point_of_element, [*of_element, self.chi, self.beta, complete])


class _Masing:
    """Iwan elements on points, by Masing's rule."""

    def __init__(self, point_of_element: NDArray[np.int64], quantities: Array) -> None:
        self.point_of_element, self.quantities = point_of_element, quantities

    def _hysteresis(self, displacement: Array) -> Hysteresis:
        """Of the elements along displacements of the points, (points, samples)."""
        return Hysteresis.of(self.quantities, displacement[self.point_of_element])


class _MasingAtSamples(_Masing, AtSamples):
    """Forces of Iwan elements at samples."""

    def evaluate(self, motion: Array, period: Period, tangent: Array) -> Array:
        """As of ``AtSamples``."""
        tables, on, force = period.tables, self.point_of_element, np.zeros_like(motion)
        hysteresis = self._hysteresis(motion @ tables.synthesis)
        np.add.at(force, on, hysteresis.force @ tables.synthesis.T * tables.weight)
        if tangent.size:
            np.add.at(tangent, on, hysteresis.tangents(tables.synthesis, tables.weight))
        return force

    def in_modes(self, rows: Sequence[Array], w: float) -> ModalElements:
        """As of ``AtSamples``."""
        return ModalIwan(rows[0][self.point_of_element], self.quantities)

    def states(self, displacement: Array, w: float) -> NDArray[np.int8]:
        """As of ``AtSamples``."""
        return _states_by(np.any(displacement[:, 0], axis=1)[self.point_of_element])


class _MasingInTime(_Masing, InTime):
    """Forces of Iwan elements in time."""

    def evaluate(self, motion: Array, w: float, samples: int) -> Array:
        """As of ``InTime``."""
        phase = 2 * np.pi * np.arange(1, samples + 1) / samples
        table = np.column_stack([np.ones(samples), np.sin(phase), np.cos(phase)])
        force, weight = np.zeros_like(motion), np.array([1.0, 2.0, 2.0]) / samples
        hysteresis = self._hysteresis(motion[:, :3] @ table.T)
        np.add.at(force[:, :3], self.point_of_element, hysteresis.force @ table * weight)
        return force


def _states_by(moves: NDArray[np.bool_]) -> NDArray[np.int8]:
    """States of elements by whether they move: some of one slips unless it is at rest."""
    return np.where(moves, STICK_SLIP, STICK).astype(np.int8)


def _complete_beta(a: float) -> float:
    """B(a, 3/2)."""
    return exp(lgamma(a) + lgamma(1.5) - lgamma(a + 1.5))


@loop
def _describing_function(
    k_p: float, phi: float, chi: float, beta: float, complete: float, amplitude: float
) -> tuple[float, float, float, float]:
    """In-phase and quadrature stiffness, and their derivatives by the logarithm of the amplitude.

    The quadrature part is the sum of ``4/pi r (1 - r)`` with r = phi / A over all that slip.
    """
    if amplitude <= phi:
        part = k_p * (amplitude / phi) ** (chi + 1)
        loss = 8 / pi * complete * part
        imag = 4 / pi * part * (chi + 1) / ((chi + 2) * (chi + 3))
        return k_p * (1 + beta) - loss, imag, -(chi + 1) * loss, (chi + 1) * imag
    x = phi / amplitude
    root = sqrt(x * (1 - x))
    if x <= 0.5:
        # series of sqrt(1 - r) in r: no difference of large terms far beyond phi_max
        term, single, total, incomplete = 1.0, 0.0, 0.0, 0.0
        for n in range(_TERMS):
            single += term / (n + 1.5)
            incomplete += term / (n + chi + 2.5)
            total += term / ((n + 1.5) * (n + chi + 2.5))
            term *= x * (n - 0.5) / (n + 1)
            if abs(term) < _NO_TERM:
                break
        scale = 8 / pi * x * sqrt(x)
        real = k_p * scale * ((chi + 1) * total + beta * single)
        incomplete *= scale
    else:
        y, term, rest = 1 - x, 1.0, 0.0
        for n in range(_TERMS):
            rest += term / (n + 1.5)
            term *= y * (n - chi - 1.5) / (n + 1)
            if abs(term) < _NO_TERM:
                break
        incomplete = 8 / pi * (complete - rest * y * sqrt(y)) / x ** (chi + 1)
        theta = 2 * atan2(sqrt(x), sqrt(1 - x))
        single = (theta - 2 * root * (1 - 2 * x)) / pi
        real = k_p * ((1 + beta) * single - incomplete)
    d_real = -k_p * ((chi + 1) * incomplete + beta * 8 / pi * x * root)
    once = (chi + 1) * x / (chi + 2) + beta * x
    twice = (chi + 1) * x * x / (chi + 3) + beta * x * x
    return real, 4 / pi * k_p * (once - twice), d_real, 4 / pi * k_p * (2 * twice - once)


@kept_loop
def _add_forces(elements: Elements, motion: Array, force: Array, tangent: Array) -> None:
    """Add the forces of all elements, and the tangents where their array is not empty."""
    point_of_element, quantities, _ = elements
    k_p, phi, chi = quantities[0], quantities[1], quantities[2]
    beta, complete = quantities[3], quantities[4]
    for e in range(point_of_element.size):
        p = point_of_element[e]
        s, c = motion[p, 0], motion[p, 1]
        amplitude = hypot(s, c)
        real, imag, d_real, d_imag = _describing_function(
            k_p[e], phi[e], chi[e], beta[e], complete[e], amplitude
        )
        force[p, 0] += real * s - imag * c
        force[p, 1] += real * c + imag * s
        if tangent.size == 0:
            continue
        # as in friction.constant, with slopes by log A: dA / A = q . dq / A^2
        unit_s, unit_c = (s / amplitude, c / amplitude) if amplitude > 0 else (0.0, 0.0)
        g_s, g_c = d_real * unit_s - d_imag * unit_c, d_real * unit_c + d_imag * unit_s
        tangent[p, 0, 0] += real + g_s * unit_s
        tangent[p, 0, 1] += -imag + g_s * unit_c
        tangent[p, 1, 0] += imag + g_c * unit_s
        tangent[p, 1, 1] += real + g_c * unit_c
