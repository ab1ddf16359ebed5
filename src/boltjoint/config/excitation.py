"""Excitation of a case: forces, a load on a surface, or a motion of the supports."""

from typing import Annotated, Literal

from pydantic import Field

from boltjoint.config.entries import Entry
from boltjoint.config.points import Direction, Force, ForcePoint
from boltjoint.config.types import Name

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
