"""Points of an assembly where forces act or motion is read."""

from typing import Annotated, Literal

from pydantic import Field

from boltjoint.config.entries import Entry
from boltjoint.config.types import Name, Number, Positive

Direction = Literal["x", "y", "z"]


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
