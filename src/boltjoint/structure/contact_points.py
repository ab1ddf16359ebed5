"""Contact points of one or more interfaces, in two tangents and a normal each."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse

from boltjoint import checks
from boltjoint.dataset import quantity

Array = NDArray[np.float64]

#: products of directions that are orthonormal but for rounding
_TURNED = 1e-9

_MOST_OF_INT32 = np.iinfo(np.int32).max

#: directions of a contact point
DIRECTIONS = 3


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """Points of one or more interfaces, each with two tangents and a normal.

    A traction t [Pa] on side A of point i is the force ``-relative_i^T area_i t`` on the structure.

    Parameters
    ----------
    relative
        Rows of the displacement of side A minus side B along the first tangent, the second one and
        the normal, positive where closing, point by point, shape (3 * points, dofs). Any
        interpolation: pairs of nodes, quadrature points, mortar.
    position
        [m], shape (points, 3).
    frame
        Directions of the tangents and the normal in x, y, z, shape (points, 3, 3).
    area
        [m2], shape (points,).
    surface
        Name of the interface of each point, shape (points,).
    gap
        By which the sides stand apart before the bolts are tightened [m], shape (points,); under
        preload where ``normal_load`` is given.
    penalty
        Static contact stiffness per area [N/m3], shape (points,).
    friction_coefficient
        While the bolts are tightened [-], shape (points,).
    normal_load
        Under preload [N], 0 where open, shape (points,); None where it is found, not given.
    """

    relative: sparse.csr_array
    position: Array
    frame: Array
    area: Array
    surface: NDArray[np.str_]
    gap: Array
    penalty: Array
    friction_coefficient: Array
    normal_load: Array | None = None

    def __post_init__(self) -> None:
        """Refuse points that do not fit each other."""
        points = len(checks.array("area of the contact points", self.area, ("points",), above=0))
        if not points:
            raise ValueError("there are no contact points")
        shapes = {"position": (points, 3), "frame": (points, 3, 3)}
        limits: dict[str, checks.Limits] = {
            name: {"at_least": 0} for name in ("gap", "friction_coefficient")
        }
        limits["penalty"] = {"above": 0}
        if self.normal_load is not None:
            limits["normal_load"] = {"at_least": 0}
        for name in ("position", "frame", *limits):
            shape = shapes.get(name, (points,))
            within: checks.Limits = limits.get(name, {})
            what = f"{name} of the contact points"
            values = checks.array(what, getattr(self, name), shape, **within)
            object.__setattr__(self, name, values)
        if self.normal_load is not None and np.any((self.normal_load > 0) & (self.gap > 0)):
            raise ValueError("normal_load of the contact points: one with a load has a gap too")
        turned = np.einsum("pij,pkj->pik", self.frame, self.frame)
        if abs(turned - np.eye(3)).max() > _TURNED:
            raise ValueError("frame of the contact points: its directions are not orthonormal")
        object.__setattr__(self, "surface", np.broadcast_to(self.surface, (points,)).astype(str))
        object.__setattr__(self, "relative", as_sparse("relative", self.relative, sparse.csr_array))
        if self.relative.shape[0] != DIRECTIONS * points:
            raise ValueError(
                f"relative of the contact points has {self.relative.shape[0]} rows: {points} of "
                f"them need {DIRECTIONS * points}, along two tangents and the normal"
            )

    @classmethod
    def of_pairs(
        cls,
        side_a: NDArray[np.integer],
        side_b: NDArray[np.integer],
        dofs: int,
        *,
        position: Array,
        area: Array,
        friction_coefficient: float | Array,
        frame: Array | None = None,
        surface: str | Sequence[str] | NDArray[np.str_] = "contact",
        gap: float | Array = 0.0,
        penalty: float | Array = 1e15,
    ) -> Self:
        """Pairs of nodes that meet.

        Parameters
        ----------
        side_a, side_b
            Degrees of freedom of the nodes along x, y, z, shape (pairs, 3).
        dofs
            Number of degrees of freedom of the structure.
        position, area, friction_coefficient, frame, surface, gap, penalty
            As the attributes, of each pair or of all; frames are x, y, z by default.
        """
        pairs = len(checks.indices("side_a", side_a, ("pairs", DIRECTIONS)))
        frames = checks.array("frame", np.eye(DIRECTIONS) if frame is None else frame)
        frame = _of_each("frame", frames, (pairs, DIRECTIONS, DIRECTIONS))
        relative = relative_of_pairs(side_a, side_b, dofs, frame)
        of_points = {
            name: _of_each(name, checks.array(name, value), (pairs,))
            for name, value in (
                ("area", area),
                ("gap", gap),
                ("penalty", penalty),
                ("friction_coefficient", friction_coefficient),
            )
        }
        surfaces = np.array(surface)
        return cls(relative, position=position, frame=frame, surface=surfaces, **of_points)

    def __len__(self) -> int:
        """Number of points."""
        return len(self.area)

    def variables(self) -> dict[str, xr.Variable]:
        """Position, area, frame and surface as the files of later stages hold them."""
        what = "of the contact pair"
        of_frame = ("pair", "direction", "axis"), self.frame, "1", f"tangents and normal {what}"
        surface = {"units": "1", "long_name": f"surface {what}"}
        return {
            "position": quantity(("pair", "axis"), self.position, "m", f"position {what}"),
            "area": quantity("pair", self.area, "m2", f"tributary area {what}"),
            "frame": quantity(*of_frame),
            "surface": xr.Variable("pair", self.surface.astype(object), surface),
            "direction": xr.Variable("direction", ["t1", "t2", "n"]),
        }


def relative_of_pairs(
    side_a: NDArray[np.integer], side_b: NDArray[np.integer], dofs: int, frame: Array
) -> sparse.csr_array:
    """Relative displacements of pairs of nodes along frames, side A minus side B.

    Parameters
    ----------
    side_a, side_b, dofs
        As for ``ContactPoints.of_pairs``.
    frame
        Tangents and normal of each pair, shape (pairs, 3, 3).

    Returns
    -------
    csr_array
        Shape (3 pairs, dofs), point by point.

    Raises
    ------
    ValueError
        If the sides are not of as many pairs, or name degrees of freedom that are not there.
    """
    dofs = checks.whole("dofs", dofs, at_least=1)
    sides = [
        checks.indices(name, side, ("pairs", DIRECTIONS))
        for name, side in (("side_a", side_a), ("side_b", side_b))
    ]
    pairs = len(sides[0])
    frame = checks.array("frame", frame, (pairs, DIRECTIONS, DIRECTIONS))
    for name, side in zip(("side_a", "side_b"), sides, strict=True):
        if side.shape[0] != pairs or not side.size:
            raise ValueError(f"{name} has {len(side)} pairs, side_a {pairs}: at least one each")
        if side.min() < 0 or side.max() >= dofs:
            raise ValueError(f"{name} has a degree of freedom that is not there")
    row = np.repeat(np.arange(DIRECTIONS * pairs), DIRECTIONS)
    entries = [
        (sign * frame.ravel(), (row, np.repeat(side, DIRECTIONS, axis=0).ravel()))
        for sign, side in zip((1.0, -1.0), sides, strict=True)
    ]
    parts = [sparse.coo_array(entry, shape=(DIRECTIONS * pairs, dofs)).tocsr() for entry in entries]
    return sum(parts[1:], parts[0])


def _of_each(name: str, value: Array, shape: tuple[int, ...]) -> Array:
    """A quantity of each point, where it may be given once for all."""
    try:
        return np.broadcast_to(value, shape)
    except ValueError as error:
        raise ValueError(f"{name} has shape {value.shape}, expected {shape}") from error


def as_sparse(name: str, matrix: Any, kind: type) -> sparse.sparray:  # noqa: ANN401
    """A sparse matrix of finite numbers."""
    if not sparse.issparse(matrix) or matrix.ndim != 2:
        raise ValueError(f"{name} is of type {type(matrix).__name__}: it must be a sparse matrix")
    compressed = kind(matrix, dtype=float)
    compressed.sum_duplicates()
    if compressed.nnz < _MOST_OF_INT32 and max(compressed.shape) < _MOST_OF_INT32:
        # half the memory of the places, and of those of all products
        compressed.indices, compressed.indptr = (
            places.astype(np.int32, copy=False)
            for places in (compressed.indices, compressed.indptr)
        )
    checks.array(f"entries of {name}", compressed.data)
    return compressed
