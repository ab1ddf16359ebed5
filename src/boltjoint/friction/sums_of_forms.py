"""Sums of the forms of several laws, each of which sees some directions of the motion."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.forms import AtSamples, ClosedForm, InTime, Period
from boltjoint.friction.modal_elements import HarmonicBasis, ModalElements, ModalTangent

Array = NDArray[np.float64]


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
        return None if any(form is None for form in of_forms) else _ModalSum(of_forms)

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
        of_parts = [each.force_and_tangent(basis, amplitude) for each in self.parts]
        force = sum(own for own, _ in of_parts)
        return force, _SumOfTangents([tangent for _, tangent in of_parts])

    def delay(self, basis: HarmonicBasis, amplitude: Array) -> Array:
        """As ``ModalElements.delay``."""
        return sum(each.delay(basis, amplitude) for each in self.parts)


class _SumOfTangents(NamedTuple):
    """As ``ModalTangent``, of several laws."""

    parts: Sequence[ModalTangent]

    def __call__(self) -> Array:
        """As ``ModalTangent``."""
        return sum(each() for each in self.parts)

    def along(self, change: Array) -> Array:
        """As ``ModalTangent.along``."""
        return sum(each.along(change) for each in self.parts)
