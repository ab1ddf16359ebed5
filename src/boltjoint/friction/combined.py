"""Several friction laws in one joint: surfaces of different laws.

The elements of each law see those directions and harmonic components of the motion that they need,
and their forces add up. A law under constant normal load whose closed form has no bias is evaluated
as that under variable load whose normal spring has no stiffness: next to elements under variable
load its points have a bias, which moves the sliders of some elements and loads the springs of all.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.dashpot_forms import Dashpots
from boltjoint.friction.declarations import LawDeclaration, combined
from boltjoint.friction.element_law import Array, ContactPairs, ElementLaw
from boltjoint.friction.forms import (
    AtSamples,
    ClosedForm,
    InTime,
    SumAtSamples,
    SumInTime,
    SumOfClosedForms,
    columns_of,
)
from boltjoint.friction.registry import LAWS
from boltjoint.friction.sliders_at_samples import Sliders, joined


def elements_by_surface(
    pairs: ContactPairs,
    law: type[ElementLaw],
    surfaces: Mapping[str, Mapping[str, Any]],
    keys: Mapping[str, float | Array],
) -> list[tuple[ElementLaw, NDArray[np.int64]]]:
    """Elements of each law, and those of the pairs that carry them.

    Parameters
    ----------
    pairs
        The contact under preload, with the surface of each pair, and its area where a key is given
        per area.
    law
        That of surfaces which name none.
    surfaces
        By the names of surfaces, ``law`` and the keys whose values replace those of all there.
    keys
        Keys of all surfaces, as for ``from_contact`` of the laws or per area. Those that the law of
        a surface does not know do not count there.

    Raises
    ------
    ValueError
        As for ``ContactPairs.keys`` and the laws, or if there is no such surface, or one lacks a
        key of its law.
    """
    names = _surfaces(pairs)
    there = np.unique(names).tolist()
    for name in surfaces:
        checks.choice("surface", name, there)
    law_of = {name: surfaces.get(name, {}).get("law", law) for name in there}
    of_laws = []
    for kind in dict.fromkeys(law_of.values()):
        mine = [name for name in there if law_of[name] is kind]
        here = np.flatnonzero(np.isin(names, mine))
        of_mine = {name: surfaces[name] for name in mine if name in surfaces}
        arguments = _keys_of(kind, pairs.at(here), keys, of_mine)
        elements, carrying = kind.from_contact(pairs.at(here), **arguments)
        of_laws.append((elements, here[carrying]))
    return of_laws


def _keys_of(
    law: type[ElementLaw],
    pairs: ContactPairs,
    keys: Mapping[str, float | Array],
    surfaces: Mapping[str, Mapping[str, Any]],
) -> dict[str, float | Array]:
    """Arguments of ``from_contact`` of a law, for the pairs of all surfaces that follow it."""
    names = [key.name for key in law.declaration.case_keys]
    forms = {form.name for key in law.declaration.case_keys for form in key.forms}
    own = {
        name: {key: value for key, value in of_surface.items() if key != "law"}
        for name, of_surface in surfaces.items()
    }
    of_all = {name: value for name, value in keys.items() if name in forms}
    values = pairs.keys(of_all, own, further=names)
    for name in names:
        lacking = np.broadcast_to(np.isnan(values.get(name, np.nan)), pairs.normal_load.shape)
        if lacking.any():
            raise ValueError(
                f"surface {_surfaces(pairs)[lacking][0]} has no {name}, which the law "
                f"{law.declaration.name!r} needs"
            )
    return values


def _surfaces(pairs: ContactPairs) -> NDArray[np.str_]:
    """Name of the surface of each pair, an empty one where they have none."""
    return np.full(pairs.normal_load.shape, "") if pairs.surface is None else pairs.surface


#: normal over tangential stiffness with which no load changes in any digit
_SOFT = 1e-200


@dataclass(frozen=True)
class CombinedLaw(ElementLaw):
    """The elements of several laws, those of one after those of another.

    Parameters
    ----------
    parts
        Elements of each law, on the same contact points.

    Raises
    ------
    ValueError
        If there are fewer than two, two of one law, or one that is no law of elements or combined.
    """

    parts: tuple[ElementLaw, ...]

    def __post_init__(self) -> None:
        """Refuse what are no parts."""
        checks.sequence("parts", self.parts, ElementLaw)
        parts = tuple(self.parts)
        kinds = {type(part) for part in parts}
        if len(parts) < 2 or len(kinds) < len(parts) or CombinedLaw in kinds:
            raise ValueError("parts must be two laws or more, each another one and none combined")
        object.__setattr__(self, "parts", parts)

    @classmethod
    def from_contact(
        cls, pairs: ContactPairs, **keys: float | Array
    ) -> tuple[Self, NDArray[np.int64]]:
        """Refuse what does not tell the law of each pair, as ``from_surfaces`` does."""
        raise ValueError("a combined law is made of those of surfaces: see elements_of_pairs")

    @classmethod
    def from_surfaces(
        cls,
        pairs: ContactPairs,
        law: type[ElementLaw],
        surfaces: Mapping[str, Mapping[str, Any]],
        keys: Mapping[str, float | Array],
    ) -> tuple[ElementLaw, NDArray[np.int64]]:
        """Elements of each surface by its own law, and the pairs that carry one.

        Parameters
        ----------
        pairs, law, surfaces, keys
            As for ``elements_by_surface``.
        """
        of_laws = elements_by_surface(pairs, law, surfaces, keys)
        # points stand in the order of the pairs, whatever the law on each
        every = np.sort(np.concatenate([carrying for _, carrying in of_laws]))
        parts = [
            part.moved_to(np.searchsorted(every, carrying)[part.point_of_element])
            for part, carrying in of_laws
        ]
        return parts[0] if len(parts) == 1 else cls(tuple(parts)), every

    def _declaration_of_parts(self) -> LawDeclaration:
        """What is known of all parts together."""
        return combined([part.declaration for part in self.parts])

    def _quantities_of_parts(self) -> dict[str, tuple[str, str]]:
        """Those of any part."""
        return {name: meaning for part in self.parts for name, meaning in part.quantities.items()}

    # of each combination, where other laws have them as classes
    declaration = cached_property(_declaration_of_parts)
    quantities = cached_property(_quantities_of_parts)

    @cached_property
    def point_of_element(self) -> NDArray[np.int64]:
        """The contact point each element acts on, counted from 0, shape (elements,)."""
        return np.concatenate([part.point_of_element for part in self.parts])

    @cached_property
    def part_of_element(self) -> NDArray[np.int64]:
        """Number of the part each element belongs to, from 0, shape (elements,)."""
        return np.repeat(np.arange(len(self.parts)), np.diff(self._first))

    @property
    def tangential_stiffness(self) -> Array:
        """Stiffness of each element in stick [N/m], shape (elements,)."""
        return np.concatenate([part.tangential_stiffness for part in self.parts])

    @property
    def slip_force(self) -> Array:
        """Force at which all of an element slips in the assembled state [N], (elements,)."""
        return np.concatenate([part.slip_force for part in self.parts])

    def stiffness_along(self, direction: str) -> Array:
        """As ``tangential_stiffness``, in a direction: 0 of a law without it."""
        of_parts = [
            part.stiffness_along(direction)
            if direction in part.directions
            else np.zeros(part.point_of_element.size)
            for part in self.parts
        ]
        return np.concatenate(of_parts)

    def quantity(self, name: str) -> Array:
        """One of the ``quantities``, not a number of elements whose law has no such."""
        of_parts = [
            part.quantity(name)
            if name in part.quantities
            else np.full(part.point_of_element.shape, np.nan)
            for part in self.parts
        ]
        return np.concatenate(of_parts)

    @property
    def features(self) -> list[Array]:
        """What tells elements apart beside their motion: the part, and all quantities."""
        return [self.part_of_element.astype(float), *map(np.nan_to_num, super().features)]

    def with_quantities(self, changed: Mapping[str, Array]) -> Self:
        """The same elements with other values of some quantities, each (elements,)."""
        return self._of_parts(
            lambda part, mine: part.with_quantities(
                {name: new[mine] for name, new in changed.items() if name in part.quantities}
            )
        )

    def moved_to(self, points: NDArray[np.int64]) -> Self:
        """The same elements on other points, shape (elements,)."""
        return self._of_parts(lambda part, mine: part.moved_to(points[mine]))

    def kept(self, elements: NDArray[np.int64], points: NDArray[np.int64], weight: Array) -> Self:
        """Some of the elements, in their order, on other points; their forces times a weight."""
        cut = np.searchsorted(elements, self._first)
        parts = [
            part.kept(elements[begin:end] - first, points[begin:end], weight[begin:end])
            for part, first, begin, end in zip(self.parts, self._first, cut, cut[1:], strict=False)
        ]
        return type(self)(tuple(parts))

    def replaced_by(
        self, point_of_element: NDArray[np.int64], tangential_stiffness: Array, slip_force: Array
    ) -> Self:
        """Other elements on the same points, by stiffness [N/m] and slip force [N] of each.

        Those on points of a part follow the law of that part, and stand in its order.
        """
        on, k, limit = point_of_element, tangential_stiffness, slip_force
        mine = [np.isin(on, part.point_of_element) for part in self.parts]
        new = (
            part.replaced_by(on[own], k[own], limit[own])
            for part, own in zip(self.parts, mine, strict=True)
        )
        return type(self)(tuple(new))

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points in stick [N/m], shape (points, directions)."""
        total = np.zeros((points, len(self.directions)))
        for part in self.parts:
            total[:, self._places(part.directions)] += part.stuck_stiffness(points)
        return total

    @cached_property
    def closed_form(self) -> ClosedForm | None:
        """The sum of the closed forms of all parts; None unless each has one beside the others."""
        if not self.declaration.has_closed_form:
            return None
        same = [
            part if part.components == self.components else _with_bias(part) for part in self.parts
        ]
        count = len(self.components)
        return SumOfClosedForms(
            [form for part in same if (form := part.closed_form) is not None],
            [columns_of(self._places(part.directions), count) for part in same],
        )

    @cached_property
    def at_samples(self) -> AtSamples:
        """The sum of those of all parts."""
        return SumAtSamples(
            [part.at_samples for part in self.parts],
            [self._places(part.directions) for part in self.parts],
        )

    @cached_property
    def in_time(self) -> InTime:
        """The sum of those of all parts."""
        own = [part.directions_in_time for part in self.parts]
        places = [[self.directions_in_time.index(name) for name in names] for names in own]
        return SumInTime([part.in_time for part in self.parts], places)

    def sliders(self) -> Sliders | None:
        """Those of all parts; None where one has none."""
        own = [sliders for part in self.parts if (sliders := part.sliders()) is not None]
        return joined(own, self._first[:-1]) if len(own) == len(self.parts) else None

    @cached_property
    def dashpots(self) -> Dashpots | None:
        """Those of all parts."""
        own = [
            (first + part.dashpots.element, part.dashpots.point, part.dashpots.damping)
            for part, first in zip(self.parts, self._first, strict=False)
            if part.dashpots is not None
        ]
        return Dashpots(*map(np.concatenate, zip(*own, strict=True))) if own else None

    @cached_property
    def _first(self) -> NDArray[np.int64]:
        """Number of the first element of each part, and of all elements."""
        return np.cumsum([0, *(part.point_of_element.size for part in self.parts)])

    def _places(self, directions: Sequence[str]) -> list[int]:
        """Places of some directions among those of all parts."""
        return [self.directions.index(direction) for direction in directions]

    def _of_parts(self, change: Callable[[ElementLaw, NDArray[np.bool_]], ElementLaw]) -> Self:
        """The law of changed parts: ``change(part, which elements are its own)``."""
        numbered = enumerate(self.parts)
        return type(self)(tuple(change(part, self.part_of_element == n) for n, part in numbered))


def elements_of_pairs(
    pairs: ContactPairs,
    law: type[ElementLaw] | str,
    surfaces: Mapping[str, Mapping[str, Any]] | None = None,
    **keys: float | Array,
) -> tuple[ElementLaw, NDArray[np.int64]]:
    """Elements of contact pairs, one on each contact point, and the pairs these points are.

    Parameters
    ----------
    pairs
        The contact under preload.
    law
        One of ``friction.registry.LAWS``, or its name.
    surfaces
        By the names of surfaces, those keys whose values replace those of all there; and ``law``,
        where the surface has another one.
    keys
        As for ``from_contact`` of the law, or per area.

    Raises
    ------
    ValueError
        As for ``ContactPairs.keys``, ``elements_by_surface`` and the law, or if it is not known.
    """
    law, surfaces = _known_law("law", law), {} if surfaces is None else surfaces
    checks.mapping("surfaces", surfaces)
    for name, own in surfaces.items():
        checks.mapping(f"surface {name}", own)
    if not any("law" in own for own in surfaces.values()):
        return law.from_contact(pairs, **pairs.keys(keys, surfaces))
    own_laws = {
        name: {**own, "law": _known_law(f"law of surface {name}", own.get("law", law))}
        for name, own in surfaces.items()
    }
    return CombinedLaw.from_surfaces(pairs, law, own_laws, keys)


def _known_law(what: str, law: type[ElementLaw] | str) -> type[ElementLaw]:
    """A law by its name, or as it is."""
    if isinstance(law, str):
        return LAWS[checks.choice(what, law, LAWS)]
    checks.subclass(what, law, ElementLaw)
    return law


def _with_bias(law: ElementLaw) -> ElementLaw:
    """Elements under constant normal load as those under variable load with soft normal springs.

    Raises
    ------
    ValueError
        If the law is not the limit of another one.
    """
    variable = law.declaration.limit_of
    if variable is None:
        raise ValueError(f"the law {law.name!r} is not the limit of one under variable load")
    return LAWS[variable](
        point_of_element=law.point_of_element,
        tangential_stiffness=law.tangential_stiffness,
        normal_stiffness=_SOFT * law.tangential_stiffness,
        normal_load=law.slip_force,
        friction_coefficient=np.ones_like(law.slip_force),
    )
