"""Two tubes with flanges and a bolt circle."""

import math
from typing import Annotated, Literal

from pydantic import Field

from boltjoint.config.bolted_bodies import LEAST_CELL, MOST_BOLTS, BoltedBodies, too_near
from boltjoint.config.entries import Entry
from boltjoint.config.grid import Cell, Grid, Lines
from boltjoint.config.types import INTEGRAL, KeyPath, Number, Positive, Problems


class TubeDimensions(Entry):
    """Dimensions of the two tubes, which are alike but for their lengths."""

    inner_diameter_mm: Positive
    """Inner diameter, of the flanges too."""
    outer_diameter_mm: Positive
    """Outer diameter."""
    length_mm: tuple[Positive, Positive]
    """Lengths of the lower tube, which is held, and of the upper one, without their flanges."""

    def conflicts(self) -> Problems:
        if self.inner_diameter_mm >= self.outer_diameter_mm:
            outer = self.outer_diameter_mm
            yield ("inner_diameter_mm",), f"must be less than the outer diameter of {outer:g} mm"


class FlangeDimensions(Entry):
    """Dimensions of the two flanges."""

    outer_diameter_mm: Positive
    """Outer diameter of both flanges."""
    thickness_mm: tuple[Positive, Positive]
    """Thicknesses of the lower and of the upper flange."""


class BoltCircle(Entry):
    """Places of the bolts."""

    diameter_mm: Positive
    """Diameter of the circle that the axes of the bolts lie on."""
    number: Annotated[int, Field(strict=True, ge=2, le=MOST_BOLTS), INTEGRAL]
    """Number of bolts, at equal distances."""
    first_angle_deg: Annotated[Number, Field(ge=-360, le=360)] = 0.0
    """Angle of the first bolt from x towards y."""


class Flange(BoltedBodies):
    """Two tubes along z whose flanges a circle of bolts holds together.

    The lower tube is held at its end or free; its flange and that of the upper tube meet at z = 0,
    and the axis of the tubes is that of z.
    """

    type: Literal["flange"]
    """Kind of structure."""
    tubes: TubeDimensions
    flange: FlangeDimensions
    bolt_circle: BoltCircle

    @property
    def bolt_angles(self) -> tuple[float, ...]:
        """Angles of the bolts from x towards y [rad]."""
        circle = self.bolt_circle
        first, step = math.radians(circle.first_angle_deg), 2 * math.pi / circle.number
        return tuple(first + step * number for number in range(circle.number))

    @property
    def bolt_positions_mm(self) -> tuple[tuple[float, float], ...]:
        """Axes of the bolts, x and y [mm]."""
        radius = self.bolt_circle.diameter_mm / 2
        return tuple(
            (radius * math.cos(angle), radius * math.sin(angle)) for angle in self.bolt_angles
        )

    @property
    def extent_mm(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest x, y and z of both bodies [mm]."""
        radius = self.flange.outer_diameter_mm / 2
        lower, upper = map(sum, zip(self.flange.thickness_mm, self.tubes.length_mm, strict=True))
        return (-radius, radius), (-radius, radius), (-lower, upper)

    @property
    def wall_mm(self) -> tuple[float, float]:
        """Inner and outer radius of the tubes [mm]."""
        return self.tubes.inner_diameter_mm / 2, self.tubes.outer_diameter_mm / 2

    @property
    def edge_distances_mm(self) -> tuple[float, float, float]:
        """Distances of axes from the tubes, from the edge of the flanges and from each other."""
        circle = self.bolt_circle
        radius = circle.diameter_mm / 2
        return (
            radius - self.wall_mm[1],
            self.flange.outer_diameter_mm / 2 - radius,
            2 * radius * math.sin(math.pi / circle.number),
        )

    @property
    def widest_cell_mm(self) -> float:
        """Side of the largest cells for which there is room [mm]."""
        to_tubes, to_edge, between = self.edge_distances_mm
        return min(2 * to_tubes, 2 * to_edge, between)

    @property
    def grid_mm(self) -> Grid:
        """Lines and cells of the flanges, by radii [mm] and angles [rad].

        Sides of a cell along radii have half its width from the axis of the bolt. Further lines go
        through the axes of the bolts and midway between them: all sectors are alike.
        """
        radius, half = self.bolt_circle.diameter_mm / 2, self.cell_mm / 2
        width = math.asin(min(half / radius, 1.0))
        angles, step = self.bolt_angles, math.pi / self.bolt_circle.number
        cells = tuple(
            Cell((radius - half, radius + half), (angle - width, angle + width)) for angle in angles
        )
        ends = [angles[0] - step, *angles, *(angle + step for angle in angles)]
        mesh = self.mesh
        lengths = mesh.element_length_mm / radius, 2 * width / mesh.elements_along_cell
        around = Lines.between(ends, [cell.second for cell in cells], *lengths)
        edge = self.flange.outer_diameter_mm / 2
        along = self._lines((*self.wall_mm, edge), [cells[0].first])
        return Grid(along, around, cells, is_closed=True)

    @property
    def lines_of_tubes(self) -> tuple[int, int, int]:
        """Elements through the wall, and along the lower and the upper tube."""
        wall = self.grid_mm.first.within(self.wall_mm)
        lower, upper = (self._lines((0.0, length), []) for length in self.tubes.length_mm)
        return wall, lower.elements, upper.elements

    @property
    def size_beside(self) -> tuple[int, int]:
        """Nodes and elements of the tubes."""
        wall, lower, upper = self.lines_of_tubes
        around, along = self.grid_mm.second.elements, lower + upper
        return along * around * (wall + 1), along * around * wall

    def conflicts(self) -> Problems:
        problems: list[tuple[KeyPath, str]] = []
        for key, what, distance, share in zip(
            (
                ("bolt_circle", "diameter_mm"),
                ("flange", "outer_diameter_mm"),
                ("bolt_circle", "number"),
            ),
            ("from bolts to the tubes", "from bolts to the edge of the flanges", "between bolts"),
            self.edge_distances_mm,
            (LEAST_CELL / 2, LEAST_CELL / 2, LEAST_CELL),
            strict=True,
        ):
            problems += too_near(key, what, distance, share, self.bolts.seat_diameter_mm)
        yield from problems
        if not problems:
            yield from super().conflicts()
        yield from self.conflicts_of_symmetry()
