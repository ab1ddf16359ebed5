"""Joint: a structure in modal coordinates, its contact points and their friction elements.

Node-to-node contact, regions and reduced joints are three ways to make the same data structure, so
solvers need not distinguish them.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import ModalStructure
from boltjoint.friction.declarations import AXES
from boltjoint.friction.element_law import ElementLaw
from boltjoint.friction.protocol import FrictionLaw
from boltjoint.joint.parts import Contact, Excitation, RelativeModes, Sensors, count_same
from boltjoint.joint.surface_places import SURFACE, SurfacePlaces

if TYPE_CHECKING:
    from matplotlib.collections import PathCollection

Array = NDArray[np.float64]

#: of the excitation level: a force, or an acceleration of the supports
EXCITATION_UNITS = ("N", "m/s2")

#: field with the relative modes in each direction that a law may need
MODES = {direction: f"{direction}_mode" for direction in AXES}

#: name of the output point where no sensors are named
OUTPUT_POINT = "output"

#: relative difference of squared frequencies below which a frequency is a multiple one
_SAME_FREQUENCY = 1e-9


@dataclass(frozen=True)
class Joint:
    """A structure in modal coordinates and the friction elements that act on it.

    Its parts are the ``structure``, its ``excitation``, its ``sensors`` and the ``contact``.

    Parameters
    ----------
    natural_frequency
        Natural frequencies of the structure without contact [Hz], shape (modes,).
    excitation_mode, response_mode
        Mass-normalised modes at the excitation and the output point [kg^-1/2], shape (modes,).
    tangential_mode
        Relative modal displacement, side A minus side B, along the first tangent (the bar in a half
        lap) at every contact point [kg^-1/2], shape (points, modes): u = tangential_mode @ q.
    position
        Position of every contact point [m], shape (points, 3).
    law
        The friction elements and which point each acts on.
    element_position
        Position of every element [m], shape (elements, 3): its contact pair, or its region's
        centre.
    normal_mode
        As ``tangential_mode``, along the normal and positive when closing, where the law needs it:
        v = normal_mode @ q.
    excitation_mode_cos
        As ``excitation_mode``, of the part of the excitation that goes with the cosine, where its
        points are not in phase: ``level (excitation_mode sin(wt) + excitation_mode_cos cos(wt))``.
    excitation_unit
        Unit of the excitation level: ``N``, or ``m/s2`` for an acceleration of the supports, under
        which the excitation modes are in kg^1/2 and motion is relative to them.
    sensor_mode
        As ``response_mode``, of each sensor, shape (sensors, modes); by default the output point
        alone.
    sensor_name
        Name of each sensor.
    free_frequency, free_participation
        Where the vectors of the basis are no modes without contact: natural frequencies of such
        modes [Hz], shape (free modes,), and ``phi_r^T M`` of them times the vectors [-], shape
        (free modes, modes).
    lateral_mode
        As ``tangential_mode``, along the second tangent, where the law needs it.
    places
        Surface of every contact point and its place there; by default one surface across z.

    Raises
    ------
    ValueError
        If an entry is not a finite number, a natural frequency is negative, the shapes do not fit
        each other, or an element sits on a point that does not exist.
    """

    natural_frequency: Array
    excitation_mode: Array
    response_mode: Array
    tangential_mode: Array
    position: Array
    law: FrictionLaw
    element_position: Array
    normal_mode: Array | None = None
    excitation_mode_cos: Array | None = None
    excitation_unit: str = "N"
    sensor_mode: Array | None = None
    sensor_name: tuple[str, ...] = ()
    free_frequency: Array | None = None
    free_participation: Array | None = None
    lateral_mode: Array | None = None
    places: SurfacePlaces | None = None

    def __post_init__(self) -> None:
        """Check the shapes and convert all entries to arrays."""
        checks.instance("law", self.law, FrictionLaw)
        frequency = checks.array(
            "natural_frequency", self.natural_frequency, ("modes",), at_least=0
        )
        position = checks.array("position", self.position, ("points", 3))
        on = self.law.point_of_element
        modes, points, elements = frequency.size, len(position), on.size
        if modes == 0:
            raise ValueError("natural_frequency is empty: a structure has at least one mode")
        checks.choice("excitation_unit", self.excitation_unit, EXCITATION_UNITS)
        checks.sequence("sensor_name", self.sensor_name, str)
        object.__setattr__(self, "sensor_name", tuple(self.sensor_name))
        expected = {
            "natural_frequency": (modes,),
            "excitation_mode": (modes,),
            "response_mode": (modes,),
            "position": (points, 3),
            "element_position": (elements, 3),
            **_shapes_where_needed(self, points, modes),
        }
        for name, shape in expected.items():
            object.__setattr__(self, name, checks.array(name, getattr(self, name), shape))
        checks.instance("places", self.surface_places, SurfacePlaces)
        checks.array("place of the points", self.surface_places.place, (points, 2))
        if elements == 0 or on.max() >= points:
            raise ValueError(
                f"point_of_element of the law: elements must sit on points 0 to {points - 1}"
            )

    def __repr__(self) -> str:
        """The joint in a line, without its arrays."""
        elements = f"{self.law.point_of_element.size} elements ({self.law.name})"
        modes = self.natural_frequency.size
        return f"<Joint of {elements} on {self.points} contact points, in {modes} modes>"

    def to_dataset(self) -> xr.Dataset:
        """What describes the elements, and where they are; files hold more (``joint.io``)."""
        return self.contact.to_dataset()

    def plot(self, name: str = "slip_force", **style: Any) -> "PathCollection":  # noqa: ANN401
        """Draw a quantity of the elements over the contact, as ``Contact.plot`` does."""
        return self.contact.plot(name, **style)

    @cached_property
    def excitation(self) -> Excitation:
        """Where the structure is excited."""
        return Excitation(self.excitation_mode, self.excitation_mode_cos, self.excitation_unit)

    @cached_property
    def sensors(self) -> Sensors:
        """Where motion is observed: the output point alone where no sensors are named."""
        if self.sensor_mode is None:
            return Sensors(self.response_mode, {OUTPUT_POINT: self.response_mode})
        by_name = dict(zip(self.sensor_name, self.sensor_mode, strict=True))
        return Sensors(self.response_mode, by_name)

    @cached_property
    def contact(self) -> Contact:
        """The contact points and the friction elements on them."""
        rows = tuple(getattr(self, MODES[direction]) for direction in self.law.directions)
        positions = self.position, self.element_position
        return Contact(self.law, rows, *positions, self.surface_places)

    def structure(self, basis: Array | None = None) -> ModalStructure:
        """The structure without contact in a basis, shape (modes, vectors), or in the modes."""
        w, free = 2 * np.pi * self.natural_frequency, self.free_frequency
        free_w = None if free is None else 2 * np.pi * free
        return ModalStructure(w, basis, free_w, self.free_participation)

    @property
    def points(self) -> int:
        """Number of contact points."""
        return len(self.position)

    @cached_property
    def surface_places(self) -> SurfacePlaces:
        """``places``, or their default."""
        return _in_one_plane(self.position) if self.places is None else self.places

    @property
    def rows(self) -> tuple[Array, ...]:
        """Modal rows of each direction the law needs, each (points, modes)."""
        return self.contact.rows

    def moved_as(self, transform: Callable[[Array], Array]) -> RelativeModes:
        """The fields of ``rows``, each transformed in the same way, for ``dataclasses.replace``."""
        needed = (MODES[direction] for direction in self.law.directions)
        return cast("RelativeModes", {name: transform(getattr(self, name)) for name in needed})

    @cached_property
    def distinct(self) -> "Joint":
        """The joint in which one element stands for all that move and slip alike.

        Its responses and backbones are those of the whole joint, at half the work where that is
        symmetric about a plane. A joint whose law is not made of elements is itself.
        """
        if not isinstance(self.law, ElementLaw):
            return self
        alike = count_alike(self)
        return self if alike.all() else keep_elements(self, alike)

    def stuck_stiffness(self) -> Array:
        """Modal stiffness the contact adds while nothing slips [s^-2], shape (modes, modes)."""
        return self.contact.stuck_stiffness()

    def stiffness_while_stuck(self) -> Array:
        """Modal stiffness of structure and contact while nothing slips [s^-2], (modes, modes)."""
        return np.diag((2 * np.pi * self.natural_frequency) ** 2) + self.stuck_stiffness()

    @cached_property
    def is_rigid(self) -> NDArray[np.bool_]:
        """Modes of the rigid body, shape (modes,): at 0 Hz, and no contact point moves in them."""
        moves = self.contact.moves_in(checks.ROUNDING_OF_MODES)
        return (self.natural_frequency == 0) & ~moves

    @property
    def elastic_modes(self) -> int:
        """Number of modes that are not those of a rigid body."""
        return int(np.count_nonzero(~self.is_rigid))

    def resonance_range(self) -> Array:
        """Each resonance without contact and while nothing slips [Hz], shape (elastic modes, 2)."""
        stuck = self.stiffness_while_stuck()
        rigid = self.natural_frequency.size - self.elastic_modes
        frequency = np.sqrt(np.linalg.eigvalsh(stuck)[rigid:]) / (2 * np.pi)
        return np.column_stack([np.sort(self.natural_frequency)[rigid:], frequency])

    def check_resonance(self, resonance: int) -> int:
        """The number of a resonance, from 1; refused where there are fewer elastic modes."""
        return checks.whole("resonance", resonance, at_least=1, at_most=self.elastic_modes)

    def place_of(self, resonance: int) -> int:
        """The place of a resonance among all modes by frequency, from 0; rigid-body modes first."""
        rigid = self.natural_frequency.size - self.elastic_modes
        return self.check_resonance(resonance) - 1 + rigid

    def check_excitation(self, resonance: int) -> None:
        """Refuse a resonance that is not excited, and an output point at rest.

        The participation ``phi . excitation`` of the stuck mode phi is compared with the modes at
        the excitation and the output point, whichever are larger: across the width of a symmetric
        structure, or where that is held, it is rounding error only. Accelerations of supports have
        another unit, and are compared with the excitation alone.

        Parameters
        ----------
        resonance
            Number of the resonance, from 1.

        Raises
        ------
        ValueError
            If the excitation has no part in it, or the output point moves in no mode.
        """
        place = self.place_of(resonance)
        excitation, by_force = self.excitation.modes, self.excitation.is_force
        excited, observed = map(np.linalg.norm, (excitation, self.sensors.output))
        rounding = checks.ROUNDING_OF_MODES * (max(excited, observed) if by_force else excited)
        squared, vectors = np.linalg.eigh(self.stiffness_while_stuck())
        own = squared[place]
        modes = vectors[:, abs(squared - own) <= _SAME_FREQUENCY * own]
        participation = np.linalg.norm(excitation @ modes)
        if participation <= rounding:
            what, unit = ("force", "kg^-1/2") if by_force else ("acceleration", "kg^1/2")
            raise ValueError(
                f"this {what} does not excite the selected modes: excitation_mode has a share of "
                f"{participation:.1g} {unit} in resonance {resonance}"
            )
        if observed <= (rounding if by_force else 0):
            raise ValueError(
                "the output point does not move in the selected modes: response_mode is at "
                f"most {abs(self.response_mode).max():.1g} kg^-1/2"
            )


def _shapes_where_needed(joint: Joint, points: int, modes: int) -> dict[str, tuple[int, ...]]:
    """Shapes of the fields that some joints have; a ``ValueError`` if a law lacks one it needs."""
    expected: dict[str, tuple[int, ...]] = {}
    for direction, name in MODES.items():
        is_needed = direction in joint.law.directions
        if is_needed != (getattr(joint, name) is not None):
            verb = "needs" if is_needed else "has no use for"
            raise ValueError(f"the law {joint.law.name!r} {verb} a {direction} mode")
        if is_needed:
            expected[name] = (points, modes)
    if joint.excitation_mode_cos is not None:
        expected["excitation_mode_cos"] = (modes,)
    if joint.sensor_mode is not None or joint.sensor_name:
        expected["sensor_mode"] = (len(joint.sensor_name), modes)
    if joint.free_frequency is not None or joint.free_participation is not None:
        of_free = () if joint.free_frequency is None else joint.free_frequency
        free = checks.array("free_frequency", of_free, ("free modes",)).size
        expected |= {"free_frequency": (free,), "free_participation": (free, modes)}
    return expected


def _in_one_plane(position: Array) -> SurfacePlaces:
    """Places of points (points, 3) that lie on one surface, along x and y."""
    return SurfacePlaces(np.full(len(position), SURFACE), position[:, :2])


def keep_elements(joint: Joint, weight: Array) -> Joint:
    """A joint of those elements that have a weight, which bear all forces times it.

    They have their stiffness and slip force times the weight, so they slip at the same displacement
    as without.

    Parameters
    ----------
    joint
        A joint whose law is made of elements.
    weight
        Weight of each element, zero of those that are left out, shape (elements,). Points without
        elements are left out, too.

    Raises
    ------
    ValueError
        If a weight is negative, or none is positive.
    """
    checks.instance("joint", joint, Joint)
    law = joint.contact.element_law
    weight = checks.array("weight", weight, law.point_of_element.shape, at_least=0)
    kept = np.flatnonzero(weight)
    if not kept.size:
        raise ValueError("weight is zero of all elements")
    points, on = np.unique(law.point_of_element[kept], return_inverse=True)
    return replace(
        joint,
        law=law.kept(kept, on, weight[kept]),
        **joint.moved_as(lambda B: B[points]),
        position=joint.position[points],
        places=joint.places and joint.places.at(points),
        element_position=joint.element_position[kept],
    )


def count_alike(joint: Joint) -> Array:
    """How many elements move and slip as each does, shape (elements,).

    It is 0 of those that another one stands for: elements on both sides of a plane of symmetry are
    alike in motion that is symmetric too. The law of the joint is made of elements.
    """
    law = joint.contact.element_law
    described = [B[law.point_of_element] for B in joint.rows]
    described += [feature[:, None] for feature in law.features]
    return count_same(described)
