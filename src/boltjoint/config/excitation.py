"""Excitation of a case, by points, a surface or the supports, and points of the structure.

``structure.excitation`` places each kind in the modes of a structure.
"""

from typing import Annotated, Literal

from pydantic import Field

from boltjoint.config.entries import Entry
from boltjoint.config.types import Name, Number, Positive

Direction = Literal["x", "y", "z"]
#: along x, y, z
Vector = tuple[Number, Number, Number]


class Point(Entry):
    """A point in the assembly and a direction; the node nearest to the point is taken."""

    x_mm: Number
    """Distance from the held end along the bar, more than half an element: held nodes do not
    move."""
    y_mm: Number
    """Distance from the centre line across the width, at most half the width to each side."""
    z_mm: Number
    """Height above the plane of contact, at most half the height to each side."""
    direction: Direction
    """Direction of the force or of the displacement."""


class Force(Entry):
    """A force by its share of the force level."""

    relative_amplitude: Positive = 1.0
    """Amplitude of the force here over the force level."""
    phase_deg: Annotated[Number, Field(ge=-360, le=360)] = 0.0
    """Angle by which the force here leads the sine of the force level."""


class ForcePoint(Force, Point):
    """A point where a force acts."""


class Sensor(Point):
    """A point where the displacement is read; the first sensor is the output point."""

    name: Name
    """Name of the sensor in results."""


class NamedPoint(Entry):
    """A node where a force may act and motion be read."""

    name: Name
    """Name of the input and output."""
    near_mm: Vector
    """Place, of which the nearest node is taken."""
    direction: Direction
    """Direction of the force or of the displacement."""


Surface = Literal["top", "bottom", "free-end", "left", "right"]


class PointForces(Entry):
    """Forces at one or several points, in phase or not.

    For example ``{kind: forces, points: [{x_mm: 403.5, y_mm: 0, z_mm: 10, direction: z}]}``.
    """

    kind: Literal["forces"]
    """The kind of excitation."""
    points: Annotated[tuple[ForcePoint, ...], Field(min_length=1)]
    """Points where the forces of ``forces_N`` act."""


class ForceAtInput(Force):
    """A force at an input of the structure."""

    name: Name
    """Name of the input, in the file of the assembly."""


class InputForces(Entry):
    """Forces at inputs that the assembly names, in phase or not.

    For example ``{kind: inputs, inputs: [{name: shaker}]}``.
    """

    kind: Literal["inputs"]
    """The kind of excitation."""
    inputs: Annotated[tuple[ForceAtInput, ...], Field(min_length=1)]
    """Inputs where the forces of ``forces_N`` act."""


class SurfaceLoad(Entry):
    """A load distributed evenly over a surface of the bars; ``forces_N`` are its totals."""

    kind: Literal["distributed"]
    """The kind of excitation."""
    surface: Surface
    """Outer surface of the bars, without what lies under bolt heads and nuts: ``top`` and
    ``bottom`` along z, ``left`` (positive) and ``right`` along y, or the end of the bars."""
    direction: Direction
    """Direction of the load."""


class BaseExcitation(Entry):
    """A harmonic acceleration of the supports, given by ``accelerations_m_per_s2``.

    All displacements are then relative to them.
    """

    kind: Literal["base"]
    """The kind of excitation."""
    direction: Direction
    """Direction of the acceleration."""


Excitation = Annotated[
    PointForces | InputForces | SurfaceLoad | BaseExcitation, Field(discriminator="kind")
]
