"""Forms in which the forces of friction elements are known: closed form, samples, time; their sums.

A law of elements composes them. Each is given the frequency of the motion, on which viscous forces
and those that depend on the rate depend; forces of dry friction do not. The forces of several laws,
each of which sees some directions of the motion, are sums of these forms.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.protocol import HarmonicBasis, Kernel, ModalElements, ModalTangent
from boltjoint.friction.sliders_at_samples import SampleTables
from boltjoint.harmonics import Components

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Period:
    """A period at whose samples forces are evaluated.

    Parameters
    ----------
    frequency
        Frequency of the motion [rad/s].
    components
        Harmonic coefficients of motion and force.
    make_tables
        Gives these components at the samples, where they are needed: they take room.
    """

    frequency: float
    components: Components
    make_tables: Callable[[], SampleTables]

    @property
    def tables(self) -> SampleTables:
        """The components at the samples."""
        return self.make_tables()


class ClosedForm(ABC):
    """Forces of one harmonic without sampling, as functions of the motion of the points.

    Motion, forces and tangents are those of ``FrictionLaw.force_and_tangent``.
    """

    @property
    def kernel(self) -> Kernel | None:
        """The compiled function of the forces; None where they depend on the frequency."""
        return None

    @abstractmethod
    def evaluate(self, motion: Array, w: float) -> Array:
        """Forces on the points under a motion of the frequency w [rad/s]."""

    @abstractmethod
    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """Forces on the points, and their derivative by the motion of each."""

    def frequency_derivative(self, motion: Array, w: float) -> Array | None:
        """Derivative of the forces by w, shape of the motion; None where they do not depend on it.

        Parameters
        ----------
        motion, w
            As for ``evaluate``.
        """
        return None

    @abstractmethod
    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """State of each element over the period, shape (elements,)."""


class AtSamples(ABC):
    """Forces of any number of harmonics by samples of a period, for AFT."""

    @abstractmethod
    def evaluate(self, motion: Array, period: Period, tangent: Array) -> Array:
        """Harmonic forces on the points.

        Parameters
        ----------
        motion
            As for ``FrictionLaw.force``.
        period
            Its frequency, components and samples.
        tangent
            To which the tangents are added, or empty.
        """

    def frequency_derivative(self, motion: Array, period: Period) -> Array | None:
        """As of ``ClosedForm``, at the frequency of the period."""
        return None

    def in_modes(self, rows: Sequence[Array], w: float) -> ModalElements | None:
        """The elements in modal coordinates; None of those that are summed by points alone.

        Parameters
        ----------
        rows
            Modal rows of the points in each direction [kg^-1/2], each (points, modes).
        w
            The frequency [rad/s].
        """
        return None

    @abstractmethod
    def states(self, displacement: Array, w: float) -> NDArray[np.int8]:
        """State of each element over a period of samples.

        Parameters
        ----------
        displacement
            Displacement of the points [m], shape (points, directions, samples).
        w
            The frequency [rad/s].
        """


class InTime(ABC):
    """Forces by following the elements in time, with no code in common with the other forms."""

    @abstractmethod
    def evaluate(self, motion: Array, w: float, samples: int) -> Array:
        """Harmonic forces on the points, as ``ElementLaw.forces_in_time``."""


@dataclass(frozen=True)
class CompiledForm(ClosedForm):
    """A closed form by a compiled function, of forces that do not depend on the frequency.

    Parameters
    ----------
    compiled
        The function and its elements.
    find_states
        States of the elements by the motion of the points.
    """

    compiled: Kernel
    find_states: Callable[[Array], NDArray[np.int8]]

    @property
    def kernel(self) -> Kernel:
        """The compiled function of the forces."""
        return self.compiled

    def evaluate(self, motion: Array, w: float) -> Array:
        """As of ``ClosedForm``."""
        force = np.zeros_like(motion)
        columns = motion.shape[1]
        add_forces, elements = self.compiled
        add_forces(elements, motion, force, np.zeros((0, columns, columns)))
        return force

    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """As of ``ClosedForm``."""
        force, tangent = np.zeros_like(motion), np.zeros((*motion.shape, motion.shape[1]))
        add_forces, elements = self.compiled
        add_forces(elements, motion, force, tangent)
        return force, tangent

    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """As of ``ClosedForm``."""
        return self.find_states(motion)


def columns_of(places: Sequence[int], components: int) -> NDArray[np.int64]:
    """Columns of directions at some places in a motion of as many components in each."""
    return (components * np.array(places)[:, None] + np.arange(components)).ravel()


@dataclass(frozen=True)
class SumOfClosedForms(ClosedForm):
    """Closed forms of several laws, by the columns of the motion that each of them sees."""

    forms: Sequence[ClosedForm]
    columns: Sequence[NDArray[np.int64]]

    def evaluate(self, motion: Array, w: float) -> Array:
        """As of ``ClosedForm``."""
        force = np.zeros_like(motion)
        for form, at, own in self._parts(motion):
            force[:, at] += form.evaluate(own, w)
        return force

    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """As of ``ClosedForm``."""
        force, tangent = np.zeros_like(motion), np.zeros((*motion.shape, motion.shape[1]))
        for form, at, own in self._parts(motion):
            of_form, tangent_of_form = form.evaluate_with_tangent(own, w)
            force[:, at] += of_form
            tangent[:, at[:, None], at] += tangent_of_form
        return force, tangent

    def frequency_derivative(self, motion: Array, w: float) -> Array | None:
        """As of ``ClosedForm``."""
        of_forms = [
            (at, form.frequency_derivative(own, w)) for form, at, own in self._parts(motion)
        ]
        return _sum_of_those_that_are(motion, of_forms)

    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """As of ``ClosedForm``."""
        return np.concatenate([form.states(own, w) for form, _, own in self._parts(motion)])

    def _parts(self, motion: Array) -> Iterator[tuple[ClosedForm, NDArray[np.int64], Array]]:
        for form, at in zip(self.forms, self.columns, strict=True):
            yield form, at, np.ascontiguousarray(motion[:, at])


@dataclass(frozen=True)
class SumAtSamples(AtSamples):
    """Forms at samples of several laws, by the places of the directions that each of them sees."""

    forms: Sequence[AtSamples]
    places: Sequence[Sequence[int]]

    def evaluate(self, motion: Array, period: Period, tangent: Array) -> Array:
        """As of ``AtSamples``."""
        force = np.zeros_like(motion)
        for form, at, own in self._parts(motion, period):
            tangent_of_form = np.zeros((len(tangent), at.size, at.size))
            force[:, at] += form.evaluate(own, period, tangent_of_form)
            if tangent.size:
                tangent[:, at[:, None], at] += tangent_of_form
        return force

    def frequency_derivative(self, motion: Array, period: Period) -> Array | None:
        """As of ``AtSamples``."""
        of_forms = [
            (at, form.frequency_derivative(own, period))
            for form, at, own in self._parts(motion, period)
        ]
        return _sum_of_those_that_are(motion, of_forms)

    def in_modes(self, rows: Sequence[Array], w: float) -> ModalElements | None:
        """As of ``AtSamples``; None unless all are summed so."""
        of_forms = [
            form.in_modes([rows[place] for place in places], w)
            for form, places in zip(self.forms, self.places, strict=True)
        ]
        known = [form for form in of_forms if form is not None]
        return _ModalSum(known) if len(known) == len(of_forms) else None

    def states(self, displacement: Array, w: float) -> NDArray[np.int8]:
        """As of ``AtSamples``."""
        of_forms = zip(self.forms, self.places, strict=True)
        return np.concatenate([form.states(displacement[:, at], w) for form, at in of_forms])

    def _parts(
        self, motion: Array, period: Period
    ) -> Iterator[tuple[AtSamples, NDArray[np.int64], Array]]:
        for form, places in zip(self.forms, self.places, strict=True):
            at = columns_of(places, len(period.components))
            yield form, at, np.ascontiguousarray(motion[:, at])


@dataclass(frozen=True)
class SumInTime(InTime):
    """Forms in time of several laws, by the places of the directions that each of them sees."""

    forms: Sequence[InTime]
    places: Sequence[Sequence[int]]

    def evaluate(self, motion: Array, w: float, samples: int) -> Array:
        """As of ``InTime``."""
        force = np.zeros_like(motion)
        for form, places in zip(self.forms, self.places, strict=True):
            at = columns_of(places, 3)
            force[:, at] += form.evaluate(np.ascontiguousarray(motion[:, at]), w, samples)
        return force


def _sum_of_those_that_are(
    motion: Array, of_forms: Sequence[tuple[NDArray[np.int64], Array | None]]
) -> Array | None:
    """Sum of arrays in some columns of the motion each; None where there is no array."""
    arrays = [(at, values) for at, values in of_forms if values is not None]
    if not arrays:
        return None
    total = np.zeros_like(motion)
    for at, values in arrays:
        total[:, at] += values
    return total


class _ModalSum(NamedTuple):
    """As ``ModalElements``, of several laws."""

    parts: Sequence[ModalElements]

    def force_and_tangent(
        self, basis: HarmonicBasis, amplitude: Array
    ) -> tuple[Array, "_SumOfTangents"]:
        """As ``ModalElements.force_and_tangent``."""
        of_parts = [part.force_and_tangent(basis, amplitude) for part in self.parts]
        force = sum((own for own, _ in of_parts), np.zeros(()))
        return force, _SumOfTangents([tangent for _, tangent in of_parts])

    def delay(self, basis: HarmonicBasis, amplitude: Array) -> Array:
        """As ``ModalElements.delay``."""
        return sum((part.delay(basis, amplitude) for part in self.parts), np.zeros(()))


class _SumOfTangents(NamedTuple):
    """As ``ModalTangent``, of several laws."""

    parts: Sequence[ModalTangent]

    def __call__(self, precision: type[np.floating] = np.float64) -> Array:
        """As ``ModalTangent``."""
        return sum((part(precision) for part in self.parts), np.zeros((), precision))

    def along(self, change: Array) -> Array:
        """As ``ModalTangent.along``."""
        return sum((part.along(change) for part in self.parts), np.zeros(()))
