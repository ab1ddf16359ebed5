"""Parts of a joint: excitation, sensors and contact.

The structure itself is a ``damping.ModalStructure``. Each part is asked for what concerns it alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.friction.element_law import ElementLaw
from boltjoint.friction.protocol import FrictionLaw
from boltjoint.joint.surface_places import SurfacePlaces

if TYPE_CHECKING:
    from matplotlib.collections import PathCollection

Array = NDArray[np.float64]

#: elements are alike whose modes and quantities differ by this share of the largest: by rounding
_ALIKE = 1e-11


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


def count_same(described: Sequence[Array]) -> Array:
    """How many elements are as each is, shape (elements,), 0 of those another one stands for.

    Parameters
    ----------
    described
        What tells elements apart, each (elements, quantities).
    """
    features = np.hstack(
        [feature / max(abs(feature).max(), np.finfo(float).tiny) for feature in described]
    )
    # alike elements are next to each other in the order of any sum of what describes them
    order = np.argsort(features @ np.cos(np.arange(features.shape[1])))
    changes = abs(np.diff(features[order], axis=0)).max(axis=1) > _ALIKE
    first = np.flatnonzero(np.concatenate([[True], changes]))
    alike = np.zeros(len(features))
    alike[np.minimum.reduceat(order, first)] = np.diff(first, append=len(features))
    return alike


class RelativeModes(TypedDict, total=False):
    """Fields of a joint with the modal rows of its points, of the directions that a law needs."""

    tangential_mode: Array
    lateral_mode: Array
    normal_mode: Array


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
    def element_law(self) -> ElementLaw:
        """The law of the elements.

        Raises
        ------
        ValueError
            If the law is not made of elements, or is evaluated by AFT.
        """
        return checks.instance("law of the joint", self.law, ElementLaw)

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

    def to_dataset(self) -> xr.Dataset:
        """What describes the elements, by ``element``, and where each is: ``x``, ``y``, ``z`` [m].

        To look at: ``joint.io.joint_to_dataset`` has all that a joint is made of.
        """
        law = self.element_law
        described = {"slip_force": quantity("element", law.slip_force, "N", "slip force")}
        for name, (unit, meaning) in law.quantities.items():
            described[name] = quantity("element", law.quantity(name), unit, meaning)
        places = {
            axis: quantity("element", place, "m", f"{axis} of the element")
            for axis, place in zip("xyz", self.element_position.T, strict=True)
        }
        return xr.Dataset(described, places, {"law": law.name})

    def plot(self, name: str = "slip_force", **style: Any) -> "PathCollection":  # noqa: ANN401
        """Draw a quantity of the elements over the contact with matplotlib, into the current axes.

        Parameters
        ----------
        name
            A variable of ``to_dataset``.
        style
            Options of ``xarray.Dataset.plot.scatter``.

        Returns
        -------
        PathCollection
            The elements, along the two axes in which they extend farthest.
        """
        described = self.to_dataset()
        checks.choice("name", name, [str(variable) for variable in described])
        along, across, _ = np.argsort(-np.ptp(self.element_position, axis=0), stable=True)
        axes = {"x": "xyz"[along], "y": "xyz"[across], "hue": name, "add_legend": False}
        return described.plot.scatter(**{**axes, **style})
