"""Parts of a joint: where its structure is excited and observed, and its contact.

The structure itself is a ``damping.ModalStructure``. Each part is asked for what concerns it alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.law import FrictionLaw
from boltjoint.joint.surface_places import SurfacePlaces

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Excitation:
    """Excitation of a structure: ``level (sine sin(wt) + cosine cos(wt))`` in modal coordinates.

    Parameters
    ----------
    sine, cosine
        Modes at the excitation, of the parts that go with sine and cosine, shape (modes,); None
        without a cosine, where all is in phase.
    unit
        Unit of the level: ``N``, or ``m/s2`` for an acceleration of the supports.
    """

    sine: Array
    cosine: Array | None
    unit: str

    @property
    def modes(self) -> NDArray:
        """Sine part + i cosine part; real where all is in phase."""
        return self.sine if self.cosine is None else self.sine + 1j * self.cosine

    @property
    def is_force(self) -> bool:
        """Whether it is a force, not an acceleration of the supports."""
        return self.unit == "N"


@dataclass(frozen=True)
class Sensors:
    """Places where the motion of a structure is observed.

    Parameters
    ----------
    output
        Modes at the output point, shape (modes,).
    by_name
        Modes at each sensor by its name.
    """

    output: Array
    by_name: Mapping[str, Array]


@dataclass(frozen=True)
class Contact:
    """Contact points of a structure and the friction elements on them.

    Parameters
    ----------
    law
        The friction elements.
    rows
        Modal rows of the points in each direction that the law needs, each (points, modes).
    position
        Positions of the points [m], shape (points, 3).
    element_position
        Positions of the elements [m], shape (elements, 3).
    places
        Surface of every point and its place there.
    """

    law: FrictionLaw
    rows: tuple[Array, ...]
    position: Array
    element_position: Array
    places: SurfacePlaces

    @property
    def points(self) -> int:
        """Number of contact points."""
        return len(self.position)

    @property
    def rows_in_plane(self) -> tuple[Array, ...]:
        """``rows`` of the directions in the plane of contact, along which friction acts."""
        return self.rows[:-1] if self.law.directions[-1] == "normal" else self.rows

    def stuck_stiffness(self) -> Array:
        """Modal stiffness the contact adds while nothing slips [s^-2], shape (modes, modes)."""
        stiffness = self.law.stuck_stiffness(self.points)
        return sum(B.T @ (k[:, None] * B) for B, k in zip(self.rows, stiffness.T, strict=True))

    def moves_in(self, rounding: float) -> NDArray[np.bool_]:
        """Modes in which a contact point moves by more than rounding, shape (modes,)."""
        moved = np.max([abs(B).max(axis=0) for B in self.rows], axis=0)
        return moved > rounding * moved.max()
