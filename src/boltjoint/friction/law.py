"""Protocol of a friction law: harmonic forces, tangents and contact states by the motion.

A law that the contact pairs of a case or the regions of a joint can have is an ``ElementLaw``: it
can also be made from the contact under preload, stored, and followed in time.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.aft_kernels import SampleTables
from boltjoint.friction.contact_pairs import ContactPairs
from boltjoint.friction.contact_states import SEPARATION, STICK, STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.friction.declarations import LawDeclaration
from boltjoint.friction.kernels import Elements
from boltjoint.friction.modal_aft import ModalSliders
from boltjoint.friction.modal_elements import ModalElements
from boltjoint.friction.sliders_at_samples import Sliders, slider_forces
from boltjoint.friction.sliders_in_time import integrate_friction

Array = NDArray[np.float64]


class FrictionLaw(ABC):
    """Friction elements on contact points, as functions of the harmonic motion of these points.

    ``force``, ``force_and_tangent`` and ``contact_state`` check the motion. Solvers, whose motions
    have the right shape by construction and may overflow, call ``evaluate`` and
    ``evaluate_with_tangent``.
    """

    #: the contact point each element acts on, counted from 0
    point_of_element: NDArray[np.int64]
    #: directions of motion that the law needs
    directions: tuple[str, ...]
    #: harmonic coefficients of the motion that the law needs
    components: tuple[str, ...]
    #: whether it has ``modal_force_and_tangent``, forces and tangents in modal coordinates
    sums_in_modal_coordinates: ClassVar[bool] = False

    def force(self, motion: Array) -> Array:
        """Harmonic forces of all elements on each point.

        Parameters
        ----------
        motion
            Coefficients of the displacements [m] in the order of ``components``, one direction
            after another, shape (points, directions * components).

        Returns
        -------
        ndarray
            Coefficients of the friction force, then, where the law has a normal direction, of the
            excess of the normal load over that of the assembled state, which is in equilibrium [N],
            shape (points, directions * components).

        Raises
        ------
        ValueError
            If the motion is not of this shape, has fewer points than there are elements on, or is
            not finite.
        """
        return self.evaluate(self._checked(motion, self._columns))

    def force_and_tangent(self, motion: Array) -> tuple[Array, Array]:
        """Harmonic forces on each point and their derivative by the motion of that point.

        Parameters
        ----------
        motion
            As for ``force``.

        Returns
        -------
        force : ndarray
            As from ``force``.
        tangent : ndarray
            ``tangent[p, i, j]`` is d force_i / d motion_j [N/m], shape (points, directions *
            components, directions * components).

        Raises
        ------
        ValueError
            As for ``force``.
        """
        return self.evaluate_with_tangent(self._checked(motion, self._columns))

    def contact_state(self, motion: Array) -> NDArray[np.int8]:
        """State of every element over the period (``friction.contact_states``).

        An element that is open for a part of the period is in stick-slip with separation, whether
        or not it slips while it is closed.

        Parameters
        ----------
        motion
            As for ``force``.

        Raises
        ------
        ValueError
            As for ``force``.
        """
        return self._states(self._checked(motion, self._columns))

    @property
    def kernel(self) -> Callable | None:
        """The compiled function that adds the forces (``friction.kernels``), None without one."""
        return None

    @abstractmethod
    def evaluate(self, motion: Array) -> Array:
        """As ``force``, without checks."""

    @abstractmethod
    def evaluate_with_tangent(self, motion: Array) -> tuple[Array, Array]:
        """As ``force_and_tangent``, without checks."""

    @abstractmethod
    def _states(self, motion: Array) -> NDArray[np.int8]:
        """As ``contact_state``, without checks."""

    @cached_property
    def _points(self) -> int:
        """Number of points up to the last one with an element."""
        return int(self.point_of_element.max(initial=-1)) + 1

    @property
    def _columns(self) -> int:
        """Number of coefficients of the motion of a point."""
        return len(self.directions) * len(self.components)

    def _checked(self, motion: Array, columns: int) -> Array:
        found = checks.array("motion", motion, ("points", columns))
        if len(found) < self._points:
            raise ValueError(
                f"motion has {len(found)} points, but there are elements on point "
                f"{self._points - 1}, counted from 0"
            )
        return found


class ElementLaw(FrictionLaw):
    """Friction elements that can be made from a contact, stored, and followed in time."""

    #: name, words, keys of a case and capabilities
    declaration: ClassVar[LawDeclaration]
    #: what describes each element beside its point, with unit and meaning
    quantities: ClassVar[dict[str, tuple[str, str]]]
    #: k of each element in stick, and the force at which all of it slips in the assembled state
    tangential_stiffness: Array
    slip_force: Array
    #: whether its forces are sums of those of its ``sliders``, each of which moves on a line
    has_sliders: ClassVar[bool] = True

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
        return (*(each for each in self.directions if each != "normal"), "normal")

    @property
    def components(self) -> tuple[str, ...]:
        """Harmonic coefficients of the motion that the law needs; one harmonic."""
        return self.declaration.components

    def stiffness_along(self, direction: str) -> Array:
        """Stiffness of each element in stick along one of the ``directions`` [N/m]."""
        # the plane of contact has one stiffness
        return self.normal_stiffness if direction == "normal" else self.tangential_stiffness

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
        return replace(self, **changed)

    def moved_to(self, points: NDArray[np.int64]) -> Self:
        """The same elements on other points, shape (elements,)."""
        return replace(self, point_of_element=points)

    def kept(self, elements: NDArray[np.int64], points: NDArray[np.int64], weight: Array) -> Self:
        """Some of the elements, in their order, on other points; their forces times a weight."""
        # forces and stiffnesses belong to the elements, ratios of them do not
        scaled = {
            name: self.quantity(name)[elements] * (1.0 if unit == "1" else weight)
            for name, (unit, _) in self.quantities.items()
        }
        return type(self)(point_of_element=points, **scaled)

    @cached_property
    def compiled_elements(self) -> Elements:
        """The elements as the kernel takes them: by default all quantities in their order."""
        return Elements.of(self.point_of_element, [getattr(self, name) for name in self.quantities])

    def evaluate(self, motion: Array) -> Array:
        """As ``force``, without checks; here by the kernel of the law."""
        force = np.zeros_like(motion)
        columns = motion.shape[1]
        self.kernel(self.compiled_elements, motion, force, np.zeros((0, columns, columns)))
        return force

    def evaluate_with_tangent(self, motion: Array) -> tuple[Array, Array]:
        """As ``force_and_tangent``, without checks; here by the kernel of the law."""
        force, tangent = np.zeros_like(motion), np.zeros((*motion.shape, motion.shape[1]))
        self.kernel(self.compiled_elements, motion, force, tangent)
        return force, tangent

    @abstractmethod
    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points in stick [N/m], shape (points, directions)."""

    @abstractmethod
    def sliders(self) -> Sliders:
        """The elements as springs with sliders; a continuous distribution by a number of them."""

    @cached_property
    def cached_sliders(self) -> Sliders:
        """The ``sliders``, made once."""
        return self.sliders()

    def evaluate_at_samples(self, motion: Array, tables: SampleTables, tangent: Array) -> Array:
        """Harmonic forces by samples of a period, for AFT; here by the ``sliders`` of the law.

        Parameters
        ----------
        motion
            As for ``force``, of any number of harmonics.
        tables
            Components of motion and force at the samples.
        tangent
            To which the tangents are added, or empty.
        """
        return slider_forces(self.cached_sliders, motion, tables, tangent)

    def in_modes(self, rows: Sequence[Array]) -> ModalElements:
        """The elements in modal coordinates, for AFT; here the ``sliders`` of the law.

        Parameters
        ----------
        rows
            Modal rows of the points in each direction [kg^-1/2], each (points, modes).
        """
        return ModalSliders.of(self.cached_sliders, rows)

    def states_at_samples(self, displacement: Array) -> NDArray[np.int8]:
        """State of each element over a period of samples; here by the ``sliders`` of the law.

        Parameters
        ----------
        displacement
            Of the points [m], shape (points, directions, samples).
        """
        found = self.cached_sliders
        along = 0 if found.lateral is None else found.lateral.astype(int)
        x = found.tangential_stiffness[:, None] * displacement[found.point, along]
        n = np.broadcast_to(found.normal_load[:, None], x.shape)
        if found.normal_stiffness is not None:
            n = n + found.normal_stiffness[:, None] * displacement[found.point, -1]
        bound = found.friction_coefficient[:, None] * np.maximum(n, 0)
        # no constant slider position lies between the bounds
        slips = (x - bound).max(axis=1) > (x + bound).min(axis=1)
        state = states_of_period(slips, n)
        # an element of several sliders slips with the first of them
        of_element = np.full(self.point_of_element.size, STICK, dtype=np.int8)
        np.maximum.at(of_element, found.element, state)
        return of_element

    def forces_in_time(self, motion: Array, samples: int) -> Array:
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
        columns = 3 * len(self.directions_in_time)
        return self.evaluate_in_time(self._checked(motion, columns), samples)

    def evaluate_in_time(self, motion: Array, samples: int) -> Array:
        """As ``forces_in_time``, without checks; here by the ``sliders`` of the law."""
        found = self.cached_sliders
        force = np.zeros_like(motion)
        normal = np.arange(motion.shape[1])[-3:]
        lateral = np.zeros(found.point.size, bool) if found.lateral is None else found.lateral
        for d in range(len(self.directions_in_time) - 1):
            mine = lateral == bool(d)
            of_direction = np.arange(3 * d, 3 * d + 3)
            at = np.concatenate([of_direction, normal])
            of_sliders = integrate_friction(
                found.point[mine],
                found.tangential_stiffness[mine],
                None if found.normal_stiffness is None else found.normal_stiffness[mine],
                found.normal_load[mine],
                found.friction_coefficient[mine],
                motion[:, at],
                samples,
            )
            acting = slice(None) if d == 0 else slice(3)
            force[:, at[acting]] += of_sliders[:, acting]
        return force


def states_of_period(slips: NDArray[np.bool_], n: Array) -> NDArray[np.int8]:
    """Contact states by whether each element slips, and its normal load at samples (``n < 0``)."""
    state = np.where(slips, STICK_SLIP, STICK)
    state[n.min(axis=1) <= 0] = STICK_SLIP_SEPARATION
    state[n.max(axis=1) <= 0] = SEPARATION
    return state.astype(np.int8)


def check_elements(
    law: ElementLaw, limits: Mapping[str, Mapping[str, float]] | None = None
) -> None:
    """Convert the quantities of the elements of a new law to arrays of one length.

    Parameters
    ----------
    law
        A frozen dataclass during its construction.
    limits
        Of those ``quantities`` that need not be positive, as for ``checks.array``.

    Raises
    ------
    ValueError
        If one is not an array of finite numbers, out of its limits, or of another length.
    """
    limits = limits or {}
    on = checks.indices("point_of_element", law.point_of_element, ("elements",))
    object.__setattr__(law, "point_of_element", on)
    for name in law.quantities:
        within = limits.get(name, {"above": 0})
        found = checks.array(name, getattr(law, name), on.shape, **within)
        object.__setattr__(law, name, found)
