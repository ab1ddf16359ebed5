"""Friction forces of any number of harmonics by alternating frequency/time (AFT).

The displacements are sampled over the period, every element is integrated through two periods of
samples, and the forces of the second are transformed to harmonics by the trapezoidal rule (Cameron
and Griffin 1989). The error of the forces is of second order in the sampling interval; the tangent
is that of the sampled forces.

References
----------
T. M. Cameron, J. H. Griffin: An alternating frequency/time domain method for calculating the
steady-state response of nonlinear dynamic systems. Journal of Applied Mechanics 56 (1989) 149-154.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.element_law import ElementLaw
from boltjoint.friction.forms import Period
from boltjoint.friction.protocol import (
    Array,
    FrictionLaw,
    HarmonicBasis,
    ModalElements,
    ModalTangent,
)
from boltjoint.friction.sliders_at_samples import SampleTables
from boltjoint.harmonics import Components


@dataclass(frozen=True)
class AlternatingFrequencyTime(FrictionLaw):
    """Friction elements of a law by AFT instead of their analytic describing function.

    Parameters
    ----------
    elements
        The friction elements.
    harmonics
        The highest harmonic of motion and force.
    samples
        Samples of the period, more than twice the harmonics.

    Raises
    ------
    ValueError
        If the elements are not those of a law, there is no harmonic, or there are too few samples
        to tell the harmonics apart.
    """

    elements: ElementLaw
    harmonics: int = 1
    samples: int = 256

    def __post_init__(self) -> None:
        """Refuse impossible harmonics and samples."""
        checks.instance("elements", self.elements, ElementLaw)
        checks.whole("harmonics", self.harmonics, at_least=1)
        checks.whole("samples", self.samples, at_least=2 * self.harmonics + 1)

    @property
    def name(self) -> str:
        """The law of the elements."""
        return self.elements.name

    @property
    def directions(self) -> tuple[str, ...]:
        """Directions of motion that the law needs."""
        return self.elements.directions

    @property
    def point_of_element(self) -> NDArray[np.int64]:
        """The contact point each element acts on, counted from 0, shape (elements,)."""
        return self.elements.point_of_element

    @property
    def tangential_stiffness(self) -> Array:
        """k_u of each element [N/m], shape (elements,)."""
        return self.elements.tangential_stiffness

    @property
    def slip_force(self) -> Array:
        """Mu n of each element in the assembled state [N], shape (elements,)."""
        return self.elements.slip_force

    @cached_property
    def components(self) -> Components:
        """Harmonic coefficients of motion and force.

        Under constant normal load the force is antisymmetric: it has no even harmonics.
        """
        is_odd = not Components(self.elements.components).has_bias
        return Components.up_to(self.harmonics, is_odd=is_odd)

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points in stick [N/m], shape (points, directions)."""
        return self.elements.stuck_stiffness(points)

    def evaluate(self, motion: Array, w: float) -> Array:
        """Harmonic forces of all elements on each point, as ``force``."""
        none = np.zeros((0, motion.shape[1], motion.shape[1]))
        return self.elements.at_samples.evaluate(motion, self._period(w), none)

    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """Harmonic forces on each point and their derivative, as ``force_and_tangent``."""
        tangent = np.zeros((*motion.shape, motion.shape[1]))
        return self.elements.at_samples.evaluate(motion, self._period(w), tangent), tangent

    def frequency_derivative(self, motion: Array, w: float) -> Array | None:
        """As of ``FrictionLaw``."""
        return self.elements.at_samples.frequency_derivative(motion, self._period(w))

    def modal_force_and_tangent(
        self, rows: tuple[Array, ...], amplitude: Array, w: float
    ) -> tuple[Array, ModalTangent] | None:
        """Harmonic forces in modal coordinates and their derivative, for any number of harmonics.

        The projection of ``force_and_tangent`` onto the modes, of amplitudes that need not be
        finite, by sums over the elements at every sample: no tangents of points are formed. None of
        elements that have no such sums.

        Parameters
        ----------
        rows
            Modal rows of the points in each direction [kg^-1/2], each (points, modes).
        amplitude
            Modal coordinates by component [kg^1/2 m], shape (components, modes).
        w
            The frequency [rad/s].

        Returns
        -------
        force : ndarray
            Shape (components, modes) [kg^-1/2 N].
        tangent : ModalTangent
            Called, d force[i, r] / d amplitude[j, s], shape (components, modes, components, modes)
            [s^-2]; or the derivative along a change of the amplitudes.

        Raises
        ------
        ValueError
            If shapes do not fit each other, the elements and the components.
        """
        amplitude, elements = self._in_modes(rows, amplitude, w)
        return None if elements is None else elements.force_and_tangent(self._basis, amplitude)

    def modal_slider_delay(
        self, rows: tuple[Array, ...], amplitude: Array, w: float
    ) -> Array | None:
        """What the delay of the sliders adds to the derivative of ``modal_force_and_tangent``.

        That is by the rate, over a period, at which a change of the motion grows
        (``ModalElements.delay``). None of elements that have no sums in modal coordinates.

        Parameters
        ----------
        rows, amplitude, w
            As for ``modal_force_and_tangent``.

        Returns
        -------
        ndarray
            Shape (components, modes, components, modes) [s^-2].

        Raises
        ------
        ValueError
            As for ``modal_force_and_tangent``.
        """
        amplitude, elements = self._in_modes(rows, amplitude, w)
        return None if elements is None else elements.delay(self._basis, amplitude)

    def _in_modes(
        self, rows: tuple[Array, ...], amplitude: Array, w: float
    ) -> tuple[Array, ModalElements | None]:
        """Modal coordinates by component, checked, and the elements in modal coordinates."""
        amplitude = checks.array(
            "amplitude", amplitude, (len(self.components), "modes"), finite=False
        )
        checks.sequence("rows", rows)
        if len(rows) != len(self.directions):
            raise ValueError(f"rows has {len(rows)} directions, expected {len(self.directions)}")
        of_points = [checks.array("rows", B, ("points", amplitude.shape[1])) for B in rows]
        if (points := min(map(len, of_points))) < self._points:
            raise ValueError(f"rows has {points} points, expected {self._points}")
        return amplitude, self.elements.at_samples.in_modes(of_points, w)

    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """As ``contact_state``, without checks."""
        return self.elements.at_samples.states(self._displacement(motion), w)

    def _period(self, w: float) -> Period:
        """The period at a frequency [rad/s], as the elements take it."""
        return Period(w, self.components, lambda: self._tables)

    @cached_property
    def _synthesis(self) -> Array:
        """Value of each component at each sample, shape (components, samples)."""
        return self.components.at_samples(self.samples)

    @cached_property
    def _weight(self) -> Array:
        """Weight of a sample in each component, shape (components,)."""
        return np.where(self.components.number == 0, 1.0, 2.0) / self.samples

    @cached_property
    def _basis(self) -> HarmonicBasis:
        """The components as the sums in modal coordinates take them."""
        of_components = self.components.number, self.components.is_sine
        return HarmonicBasis(*of_components, self._synthesis, self._weight, self._mean)

    @cached_property
    def _mean(self) -> Array:
        """Cumulative sums of the samples' contributions to each component.

        Shape (samples + 1, components); the contribution of an interval is a difference of two.
        """
        return _sums(self._synthesis.T * self._weight)

    @cached_property
    def _tables(self) -> SampleTables:
        """The components at the samples, as the elements take them."""
        contribution = self._synthesis.T * self._weight
        square = _sums(contribution[:, :, None] * self._synthesis.T[:, None, :])
        return SampleTables(self._synthesis, self._weight, self._mean, square)

    def _displacement(self, motion: Array) -> Array:
        """Displacement of the points at the samples [m], shape (points, directions, samples)."""
        components = motion.reshape(-1, len(self.components))
        return (components @ self._synthesis).reshape(len(motion), -1, self.samples)


def by_samples(law: FrictionLaw, samples: int) -> AlternatingFrequencyTime:
    """The elements of a law by AFT, in one harmonic; AFT itself as it is."""
    if isinstance(law, AlternatingFrequencyTime):
        return law
    return AlternatingFrequencyTime(elements_of(law), samples=samples)


def without_sampling(law: FrictionLaw) -> FrictionLaw:
    """The law of the elements in place of AFT of it; another law as it is."""
    return law.elements if isinstance(law, AlternatingFrequencyTime) else law


def elements_of(law: FrictionLaw) -> ElementLaw:
    """The law of the elements, whether or not their forces are by AFT.

    Raises
    ------
    ValueError
        If the law is not made of elements.
    """
    return checks.instance("law", without_sampling(law), ElementLaw)


def _sums(values: Array) -> Array:
    """Cumulative sums along the first axis, from zero."""
    return np.concatenate([np.zeros_like(values[:1]), np.cumsum(values, axis=0)])
