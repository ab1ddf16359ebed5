"""Laws of friction elements: made from contact pairs, stored, evaluated in several forms.

A law composes the forms in which its forces are known (``friction.forms``).
"""

from abc import abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self, Unpack

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.dashpot_forms import Dashpots, SamplesWithDashpots, TimeWithDashpots
from boltjoint.friction.declarations import PER_AREA, LawDeclaration, is_per_area
from boltjoint.friction.forms import AtSamples, ClosedForm, InTime
from boltjoint.friction.protocol import Elements, FrictionLaw, Kernel, in_radians
from boltjoint.friction.slider_forms import SlidersAtSamples, SlidersInTime
from boltjoint.friction.sliders_at_samples import Sliders

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContactPairs:
    """Contact pairs in the assembled state, of which a law makes its elements.

    ``normal_load`` [N], 0 where open, ``gap`` [m], 0 where closed, and ``position`` [m] have the
    shape (pairs,), the last (pairs, 3); so have ``area`` [m2] and the name of the ``surface``, of
    pairs whose keys are given per area or by surface.
    """

    normal_load: Array
    gap: Array
    position: Array
    area: Array | None = None
    surface: NDArray[np.str_] | None = None

    def of_each(self, name: str, value: float | Array, **limits: Unpack[checks.Limits]) -> Array:
        """A quantity of every pair, shape (pairs,), from that of all or of each.

        ``limits`` as for ``checks.number``.
        """
        return checks.of_each(name, value, self.normal_load.shape, **limits)

    def at(self, some: NDArray[np.int64]) -> "ContactPairs":
        """Some of the pairs."""
        return ContactPairs(
            self.normal_load[some],
            self.gap[some],
            self.position[some],
            None if self.area is None else self.area[some],
            None if self.surface is None else self.surface[some],
        )

    def keys(
        self,
        keys: Mapping[str, float | Array],
        of_surfaces: Mapping[str, Mapping[str, Any]] | None = None,
        further: Collection[str] = (),
    ) -> dict[str, float | Array]:
        """Arguments of ``ElementLaw.from_contact``: those per area times the area of each pair.

        Parameters
        ----------
        keys
            By the names of ``ContactKey``, in SI units.
        of_surfaces
            By the names of surfaces, the keys whose values replace those of all there, in any form.
        further
            Names of keys that each surface may have where not all have them.

        Raises
        ------
        ValueError
            If a quantity is given for each pair and per area, there is no such surface, or it has a
            quantity that not all have.
        """
        checks.mapping("keys", keys)
        values = self._of_areas(keys)
        if not of_surfaces:
            return values
        checks.mapping("surfaces", of_surfaces)
        names = self.surface if self.surface is not None else np.array([""])
        for name, own in of_surfaces.items():
            checks.choice("surface", name, np.unique(names).tolist())
            checks.mapping(f"surface {name}", own)
            here = np.flatnonzero(names == name)
            for key, value in self.at(here)._of_areas(own).items():
                checks.choice(f"key of surface {name}", key, {**values, **dict.fromkeys(further)})
                # in turn: a surface may have values of each pair where all have one
                of_all = values.get(key, np.nan)
                of_pairs = np.array(np.broadcast_to(of_all, self.normal_load.shape), dtype=float)
                of_pairs[here] = value
                values[key] = of_pairs
        return values

    def _of_areas(self, keys: Mapping[str, float | Array]) -> dict[str, float | Array]:
        """Quantities of each pair, of which some are given per area."""
        values: dict[str, float | Array] = {}
        for name, value in keys.items():
            of_pair = name.removesuffix(PER_AREA)
            if of_pair in values:
                raise ValueError(f"{of_pair} is given for each pair and per area: give one of them")
            if not is_per_area(name):
                values[of_pair] = value
            elif self.area is None:
                raise ValueError(f"{name} needs the area of the pairs")
            else:
                values[of_pair] = value * self.area
        return values


class ElementLaw(FrictionLaw):
    """Friction elements that can be made from a contact, stored, and evaluated in several forms.

    A law is a frozen dataclass of ``point_of_element`` and its ``quantities``. It has a
    ``closed_form``, or None, and the forms at samples and in time, which by default are those of
    its ``sliders`` and ``dashpots``; a law without sliders on lines brings these two itself.
    """

    #: name, words and keys of a case
    declaration: ClassVar[LawDeclaration]
    #: what describes each element beside its point, with unit and meaning
    quantities: ClassVar[dict[str, tuple[str, str]]]
    #: names that each law has, the last two as fields or properties: by these regions are made and
    #: amplitudes scaled
    _ASKED: ClassVar = ("declaration", "quantities", "tangential_stiffness", "slip_force")

    if TYPE_CHECKING:
        # that of the dataclass, but of combined laws
        def __init__(self, point_of_element: NDArray[np.int64], **quantities: Array) -> None: ...

    def __init_subclass__(cls) -> None:
        """Refuse a law that lacks what is asked of all of them."""
        super().__init_subclass__()
        own = [
            base for base in cls.__mro__ if issubclass(base, ElementLaw) and base is not ElementLaw
        ]
        names = {name for base in own for name in (*vars(base), *base.__annotations__)}
        if lacking := [name for name in cls._ASKED if name not in names]:
            raise TypeError(f"the law {cls.__name__} has no {' and no '.join(lacking)}")
        declared = isinstance(cls.declaration, LawDeclaration) and cls.declaration.has_closed_form
        if declared and cls.closed_form is None:
            raise TypeError(f"the law {cls.__name__} declares a closed form, which it has not")

    @property
    @abstractmethod
    def closed_form(self) -> ClosedForm | None:
        """Forces of one harmonic without sampling; None where there is no closed form."""

    @cached_property
    def at_samples(self) -> AtSamples:
        """Forces of any number of harmonics by samples, for AFT."""
        form = SlidersAtSamples(self._known_sliders, self.point_of_element.size)
        return form if self.dashpots is None else SamplesWithDashpots(form, self.dashpots)

    @cached_property
    def in_time(self) -> InTime:
        """Forces by following the elements in time."""
        form = SlidersInTime(self._known_sliders)
        return form if self.dashpots is None else TimeWithDashpots(form, self.dashpots)

    def sliders(self) -> Sliders | None:
        """The elements as springs with sliders; a continuous distribution by a number of them.

        None of elements that are not the sum of sliders on lines, which time integration does not
        know.
        """
        return None

    @cached_property
    def dashpots(self) -> Dashpots | None:
        """Dashpots beside the sliders; None without any."""
        return None

    @property
    def name(self) -> str:
        """The law in files."""
        return self.declaration.name

    @property
    def directions(self) -> tuple[str, ...]:
        """Directions of motion that the law needs."""
        return self.declaration.directions

    @property
    def directions_in_time(self) -> tuple[str, ...]:
        """Directions of motion that ``forces_in_time`` takes: the normal one always."""
        in_plane = (name for name in self.directions if name != "normal")
        return (*in_plane, "normal")

    @property
    def components(self) -> tuple[str, ...]:
        """Harmonic coefficients of the motion that the law needs; one harmonic."""
        return self.declaration.components

    def stiffness_along(self, direction: str) -> Array:
        """Stiffness of each element in stick along one of the ``directions`` [N/m]."""
        # the plane of contact has one stiffness
        return (
            self.quantity("normal_stiffness")
            if direction == "normal"
            else self.tangential_stiffness
        )

    @classmethod
    @abstractmethod
    def from_contact(
        cls, pairs: ContactPairs, **keys: float | Array
    ) -> tuple[Self, NDArray[np.int64]]:
        """Elements of the contact pairs, one on each point, and the pairs that carry one.

        Parameters
        ----------
        pairs
            The contact under preload.
        keys
            By the names of ``declaration.keys``, in SI units, of all pairs or of each, shape
            (pairs,).

        Raises
        ------
        ValueError
            If a key is out of its range.
        """

    def quantity(self, name: str) -> Array:
        """One of the ``quantities`` of each element, shape (elements,)."""
        return getattr(self, name)

    @property
    def features(self) -> list[Array]:
        """What tells elements apart beside their motion, each (elements,)."""
        return [self.quantity(name) for name in self.quantities]

    def with_quantities(self, changed: Mapping[str, Array]) -> Self:
        """The same elements with other values of some quantities, each (elements,)."""
        return self._remade(self.point_of_element, changed)

    def moved_to(self, points: NDArray[np.int64]) -> Self:
        """The same elements on other points, shape (elements,)."""
        return self._remade(points, {})

    def _remade(self, points: NDArray[np.int64], changed: Mapping[str, Array]) -> Self:
        """The same elements on points, with other values of some quantities."""
        own = {name: self.quantity(name) for name in self.quantities}
        return type(self)(points, **own | dict(changed))

    def kept(self, elements: NDArray[np.int64], points: NDArray[np.int64], weight: Array) -> Self:
        """Some of the elements, in their order, on other points; their forces times a weight."""
        # forces and stiffnesses belong to the elements, ratios of them do not
        scaled = {
            name: self.quantity(name)[elements] * (1.0 if unit == "1" else weight)
            for name, (unit, _) in self.quantities.items()
        }
        return type(self)(points, **scaled)

    def replaced_by(
        self, point_of_element: NDArray[np.int64], tangential_stiffness: Array, slip_force: Array
    ) -> "ElementLaw":
        """Other elements on the same points, by stiffness [N/m] and slip force [N] of each.

        Raises
        ------
        ValueError
            If these do not tell the elements of the law.
        """
        raise ValueError(f"the law {self.name!r} has no elements by stiffness and slip force alone")

    @abstractmethod
    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points in stick [N/m], shape (points, directions)."""

    @cached_property
    def compiled_elements(self) -> Elements:
        """The elements as kernels take them: by default all quantities in their order."""
        return Elements.of(self.point_of_element, [getattr(self, name) for name in self.quantities])

    @property
    def kernel(self) -> Kernel | None:
        """As of its closed form."""
        return None if self.closed_form is None else self.closed_form.kernel

    def evaluate(self, motion: Array, w: float) -> Array:
        """As ``force``, without checks, in closed form."""
        return self._existing_form.evaluate(motion, w)

    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """As ``force_and_tangent``, without checks, in closed form."""
        return self._existing_form.evaluate_with_tangent(motion, w)

    def frequency_derivative(self, motion: Array, w: float) -> Array | None:
        """As of ``FrictionLaw``, in closed form."""
        return self._existing_form.frequency_derivative(motion, w)

    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """As ``contact_state``, without checks, in closed form."""
        return self._existing_form.states(motion, w)

    @cached_property
    def _existing_form(self) -> ClosedForm:
        """The closed form.

        Raises
        ------
        ValueError
            If there is none.
        """
        if self.closed_form is None:
            raise ValueError(
                f"the law {self.name!r} has no closed form: evaluate it by AFT (friction_force: "
                "aft)"
            )
        return self.closed_form

    @cached_property
    def _known_sliders(self) -> Sliders:
        """The ``sliders``, made once."""
        sliders = self.sliders()
        if sliders is None:
            raise TypeError(f"the law {type(self).__name__} has neither sliders nor other forms")
        return sliders

    def forces_in_time(self, motion: Array, samples: int, frequency: float = 0.0) -> Array:
        """Harmonic forces on points by following all elements from rest, sample by sample.

        From the assembled state the points move to the start of the period, through one period, and
        through that which is evaluated by the trapezoidal rule. Nothing is shared with ``force``.

        Parameters
        ----------
        motion
            Bias, sine and cosine coefficients of the points' displacement [m] in each direction of
            ``directions_in_time``, the normal one last and positive when closing, shape (points, 3
            * directions).
        samples
            Steps a period.
        frequency
            As for ``force``.

        Returns
        -------
        ndarray
            Coefficients of the friction force in each direction, then of the change of the normal
            load from the assembled state [N], shape of the motion.

        Raises
        ------
        ValueError
            As for ``force``, or if there are fewer than three samples.
        """
        samples = checks.whole("samples", samples, at_least=3)
        motion = self._checked(motion, 3 * len(self.directions_in_time))
        return self.in_time.evaluate(motion, in_radians(frequency), samples)


def check_elements(law: ElementLaw, limits: Mapping[str, checks.Limits] | None = None) -> None:
    """Convert the quantities of the elements of a new law to arrays of one length.

    Parameters
    ----------
    law
        A frozen dataclass during its construction.
    limits
        Limits of those ``quantities`` that need not be positive, as for ``checks.array``.

    Raises
    ------
    ValueError
        If one is not an array of finite numbers, out of its limits, or of another length.
    """
    limits, positive = limits or {}, checks.Limits(above=0)
    on = checks.indices("point_of_element", law.point_of_element, ("elements",))
    object.__setattr__(law, "point_of_element", on)
    for name in law.quantities:
        within = limits.get(name, positive)
        values = checks.array(name, law.quantity(name), on.shape, **within)
        object.__setattr__(law, name, values)
