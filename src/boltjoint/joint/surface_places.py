"""Places of contact points on surfaces.

Surfaces lie anywhere in space. Where points are compared by their distances along and across a
surface, as those of regions and pictures, their places in its plane count: along the mean
directions of the tangents of its points.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks

Array = NDArray[np.float64]

#: surface where none is named
SURFACE = "contact"

#: points closer than this [m] are one
SAME_POINT = 1e-9

#: length of the mean of unit vectors below which they have no direction in common
_NO_DIRECTION = 1e-6


@dataclass(frozen=True, eq=False)
class SurfacePlaces:
    """Surface of each contact point, and its place there.

    Attributes
    ----------
    name
        Name of the surface of each point, shape (points,).
    place
        Along the first and the second tangent of the surface [m], shape (points, 2), the second one
        from the middle of the surface's width.

    Raises
    ------
    ValueError
        If the shapes do not fit each other, or a place is not finite.
    """

    name: NDArray[np.str_]
    place: Array

    def __post_init__(self) -> None:
        """Check the shapes and convert both to arrays."""
        place = checks.array("place", self.place, ("points", 2))
        object.__setattr__(self, "place", place)
        names = np.asarray(self.name)
        if names.ndim > 1 or (names.ndim == 1 and len(names) != len(place)):
            raise ValueError(f"name of surfaces has shape {names.shape}, expected ({len(place)},)")
        object.__setattr__(self, "name", np.broadcast_to(names, len(place)).astype(str))

    @classmethod
    def of(cls, name: str, stored: xr.Dataset) -> Self:
        """Of the contact pairs of a dataset of this name.

        ``position`` (pair, axis) [m]; ``surface`` (pair), one where there is none; ``frame`` (pair,
        direction, axis), x, y, z where there is none.
        """
        position = checks.variable(name, stored, "position", ("pair", "axis"))
        checks.array(f"position of {name}", position, ("pairs", 3))
        surface, frame = surfaces_of(name, stored, "pair"), np.eye(3)
        if "frame" in stored:
            frame = checks.variable(name, stored, "frame", ("pair", "direction", "axis"))
        return cls.in_planes(position, np.broadcast_to(frame, (len(position), 3, 3)), surface)

    @classmethod
    def in_planes(cls, position: Array, frame: Array, name: NDArray[np.str_]) -> Self:
        """Of points at positions [m], shape (points, 3).

        Parameters
        ----------
        position
            Shape (points, 3).
        frame
            Directions of the tangents and the normal of each point in x, y, z, (points, 3, 3).
        name
            Name of the surface of each point, shape (points,).
        """
        place = np.empty((len(position), 2))
        for surface in np.unique(name):
            mine = name == surface
            along, across = (position[mine] @ t for t in _mean_tangents(frame[mine]))
            place[mine] = np.column_stack([along, across - (across.min() + across.max()) / 2])
        return cls(name, place)

    @property
    def number(self) -> NDArray[np.int64]:
        """Number of the surface of each point, from 0 in the order of their names."""
        return np.unique(self.name, return_inverse=True)[1]

    @property
    def from_middle(self) -> Array:
        """Places along the first tangent from the middle of each surface [m], shape (points,)."""
        x, middle = self.place[:, 0], np.empty(len(self.place))
        for surface in np.unique(self.name):
            mine = self.name == surface
            middle[mine] = (x[mine].min() + x[mine].max()) / 2
        return x - middle

    def at(self, points: NDArray[np.int64]) -> Self:
        """Those of some of the points."""
        return type(self)(self.name[points], self.place[points])

    def merged(self, mean: Array, region: NDArray[np.int64]) -> Self:
        """Those of regions: ``mean`` (regions, points) of the points of each.

        Raises
        ------
        ValueError
            If a region has points of two surfaces.
        """
        first = np.unique(region, return_index=True)[1]
        if np.any(self.name != self.name[first][region]):
            wrong = np.flatnonzero(self.name != self.name[first][region])[0]
            raise ValueError(
                f"region {region[wrong]} has points of {self.name[first][region[wrong]]} and of "
                f"{self.name[wrong]}: a region lies on one surface"
            )
        return type(self)(self.name[first], mean @ self.place)


def surfaces_of(name: str, stored: xr.Dataset, of: str) -> NDArray[np.str_]:
    """Names of surfaces that a dataset of this name has along a dimension, one where it has none.

    Raises
    ------
    ValueError
        If they lie along another dimension.
    """
    if "surface" not in stored:
        return np.full(stored.sizes[of], SURFACE)
    if stored["surface"].dims != (of,):
        dims = ", ".join(map(str, stored["surface"].dims))
        raise ValueError(f"surface of {name} is over ({dims}), expected ({of})")
    return stored["surface"].to_numpy().astype(str)


def _mean_tangents(frame: Array) -> tuple[Array, Array]:
    """Orthonormal mean directions of the tangents of the points of a surface."""
    first = _direction(frame[:, 0])
    second = frame[:, 1] - np.outer(frame[:, 1] @ first, first)
    return first, _direction(second)


def _direction(vectors: Array) -> Array:
    """Unit vector along the mean of vectors, along the longest of them where that vanishes."""
    mean = vectors.mean(axis=0)
    if np.linalg.norm(mean) < _NO_DIRECTION:
        mean = vectors[np.argmax(np.linalg.norm(vectors, axis=1))]
    return mean / np.linalg.norm(mean)


def pairs_of_elements(position: Array, joint: xr.Dataset) -> NDArray[np.int64]:
    """The contact pair that each element of a joint sits on, shape (elements,).

    Parameters
    ----------
    position
        Positions of all pairs [m], shape (pairs, 3).
    joint
        With ``element_position`` (element, axis).

    Raises
    ------
    ValueError
        If an element sits on none.
    """
    from scipy.spatial import KDTree  # takes long to import

    element = joint["element_position"].transpose("element", "axis").to_numpy()
    distance, pair = KDTree(position).query(element)
    if distance.max() > SAME_POINT:
        raise ValueError(f"{np.sum(distance > SAME_POINT)} elements lie on no contact pair")
    return np.asarray(pair)
