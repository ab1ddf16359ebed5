"""Contact of a structure from another program: points, their surfaces, directions and loads."""

from collections.abc import Iterable, Sequence
from typing import Literal

from boltjoint.config.entries import Entry
from boltjoint.config.excitation import Vector
from boltjoint.config.types import (
    KeyPath,
    Name,
    NotNegative,
    Positive,
    Problems,
    VariableName,
)

#: sine of the angle below which two directions are one
_PARALLEL = 1e-6


class Plane(Entry):
    """Contact of a surface: directions and static contact."""

    normal: Vector | None = None
    """Normal from side A into side B, along x, y, z, of any length."""
    first_tangent: Vector | None = None
    """First tangent along x, y, z: its part in the plane of the surface counts."""
    penalty_N_per_m3: Positive | None = None
    """Static normal contact stiffness for each unit of area."""
    friction_coefficient: NotNegative | None = None
    """Coulomb friction during tightening."""


class MatrixSurface(Plane):
    """One of several surfaces in contact; what it does not give is that of all."""

    name: Name
    """Name of the surface in results."""


class MatrixContact(Plane):
    """Contact points: pairs of nodes, or rows of the relative displacement at quadrature points.

    Displacements of side A minus side B count, so that surfaces close along the normal.
    """

    normal: Vector | None = None
    """Normal from side A into side B along x, y, z, of any length; z by default."""
    first_tangent: Vector | None = None
    """First tangent along x, y, z: its part in the plane of the surface counts; x by default."""
    penalty_N_per_m3: Positive = 1e15
    """Static normal contact stiffness for each unit of area."""
    friction_coefficient: NotNegative = 0.1
    """Coulomb friction during tightening."""
    side_a: VariableName | None = None
    """Variable of the degrees of freedom along x, y, z of the nodes on side A of pairs, (points,
    3); with ``side_b``, or else ``relative``."""
    side_b: VariableName | None = None
    """The same on side B."""
    relative: VariableName | None = None
    """Variable of the rows of the displacement of side A minus side B at each point, of any
    interpolation, (3 * points, degrees of freedom)."""
    relative_along: Literal["xyz", "frame"] = "xyz"
    """Directions of these rows: x, y, z, or the two tangents and the normal."""
    relative_by: Literal["point", "direction"] = "point"
    """Order of these rows: the three of one point after another, or all points of one direction
    after another."""
    area: VariableName = "area"
    """Variable of the areas of the points, which are the weights of the quadrature, (points)."""
    position: VariableName = "position"
    """Variable of the positions of the points, (points, 3)."""
    frame: VariableName | None = None
    """Variable of the directions of first tangent, second tangent and normal in x, y, z of each
    point, (points, 3, 3) or (points, 9); by default ``normal`` and ``first_tangent`` of its
    surface."""
    gap: VariableName | None = None
    """Variable of the gap of the points before tightening, (points); closed by default. With
    ``normal_load`` it is that under preload."""
    normal_load: VariableName | None = None
    """Variable of the normal loads of the points under preload, in N, 0 where open, (points): taken
    as they are, in place of ``bolts``."""
    preload_N: Positive | None = None
    """Preload of each bolt under which ``normal_load`` was found: that of all cases."""
    surface: VariableName | None = None
    """Variable of the number of each point's surface in ``surfaces``, (points), with two or
    more."""
    surfaces: tuple[MatrixSurface, ...] = ()
    """Surfaces that are told apart; by default one, called contact."""

    def conflicts(self) -> Problems:
        pairs = [key for key in ("side_a", "side_b") if getattr(self, key) is not None]
        if (self.normal_load is None) != (self.preload_N is None):
            present, missing = ("normal_load", "preload_N")[:: 1 if self.normal_load else -1]
            yield (missing,), f"is missing: {present} goes with it"
        if self.relative is not None and pairs:
            yield (pairs[0],), "must not be given with relative: give one of both"
        elif self.relative is None and len(pairs) < 2:
            missing = "side_b" if pairs == ["side_a"] else "side_a"
            yield (missing,), "is missing: give side_a and side_b, or relative"
        if self.relative is None:
            for key in ("relative_along", "relative_by"):
                if getattr(self, key) != type(self).model_fields[key].default:
                    yield (key,), "must not be given without relative"
        if len(self.surfaces) > 1 and self.surface is None:
            yield ("surface",), "is missing: variable of the number of each point's surface"
        if len(self.surfaces) < 2 and self.surface is not None:
            yield ("surface",), "must not be given without two or more surfaces"
        yield from repeated(("surfaces",), "name", self.surfaces)
        for path, plane in [
            ((), self),
            *((("surfaces", i), s) for i, s in enumerate(self.surfaces)),
        ]:
            yield from self._conflicts_of_directions(path, plane)

    def _conflicts_of_directions(self, path: KeyPath, plane: Plane) -> Problems:
        if self.frame is not None:
            for key in ("normal", "first_tangent"):
                if getattr(plane, key) is not None:
                    yield (*path, key), "must not be given with frame, which holds all directions"
            return
        normal, tangent = self.directions(plane)
        for key, vector in (("normal", normal), ("first_tangent", tangent)):
            if not any(vector):
                yield (*path, key), "must not be zero"
                return
        if _sine(normal, tangent) < _PARALLEL:
            yield (*path, "first_tangent"), "must not be parallel to the normal"

    def directions(self, plane: Plane) -> tuple[Vector, Vector]:
        """Normal and first tangent of a surface, of any length."""
        normal = plane.normal or self.normal or (0.0, 0.0, 1.0)
        return normal, plane.first_tangent or self.first_tangent or (1.0, 0.0, 0.0)


def repeated(path: KeyPath, key: str, entries: Sequence[Entry]) -> Problems:
    """Entries of a list that have the same value of a key as one before."""
    seen: set[str] = set()
    for index, entry in enumerate(entries):
        value = getattr(entry, key)
        if value in seen:
            yield (*path, index, key), "must not appear twice"
        seen.add(value)


def _sine(one: Iterable[float], other: Iterable[float]) -> float:
    """Sine of the angle between two directions."""
    (a, b, c), (d, e, f) = one, other
    product = (b * f - c * e) ** 2 + (c * d - a * f) ** 2 + (a * e - b * d) ** 2
    return (product / ((a * a + b * b + c * c) * (d * d + e * e + f * f))) ** 0.5
