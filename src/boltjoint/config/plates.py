"""A single-lap shear joint: two plates that overlap, with a pattern of bolts."""

from typing import Annotated, Literal

from pydantic import Field

from boltjoint.config.bolted_bodies import LEAST_CELL, MOST_BOLTS, BoltedBodies, too_near
from boltjoint.config.entries import Entry
from boltjoint.config.grid import Cell, Grid
from boltjoint.config.types import INTEGRAL, KeyPath, Number, Positive, Problems

_BoltCount = Annotated[int, Field(strict=True, ge=1, le=MOST_BOLTS), INTEGRAL]


class PlateDimensions(Entry):
    """Dimensions of the two plates."""

    width_mm: Positive
    """Width of both plates (y)."""
    thickness_mm: tuple[Positive, Positive]
    """Thicknesses (z) of the lower plate, which is held, and of the upper one."""
    free_length_mm: tuple[Positive, Positive]
    """Lengths outside the lap: from the held end to the lap, and from the lap to the free end."""
    lap_mm: Positive
    """Length of the lap (x)."""


class Pattern(Entry):
    """Places of the bolts: rows across the plates, one after another along them."""

    rows: _BoltCount
    """Rows of bolts, one after another along the plates (x)."""
    columns: _BoltCount
    """Bolts of a row, side by side across the plates (y)."""
    pitch_mm: Positive | None = None
    """Distance of two rows; of one row there is none."""
    gauge_mm: Positive | None = None
    """Distance of two bolts of a row; of one column there is none."""
    staggered: Annotated[bool, Field(strict=True)] = False
    """Whether every second row has a bolt less, whose bolts lie between those of the rows beside
    it."""
    offset_mm: tuple[Number, Number] = (0.0, 0.0)
    """Place of the middle of the pattern from that of the lap, along x and y: (0, 0) is centred."""

    def conflicts(self) -> Problems:
        for key, number, what in (
            ("pitch_mm", self.rows, "rows"),
            ("gauge_mm", self.columns, "bolts of a row"),
        ):
            given = getattr(self, key)
            if number > 1 and given is None:
                yield (key,), f"is missing: distance of two {what}"
            elif number == 1 and given is not None:
                yield (key,), f"must not be given with one of {what}"
        if self.rows * self.columns > MOST_BOLTS:
            yield ("rows",), f"must give at most {MOST_BOLTS} bolts with columns"
        if self.staggered and min(self.rows, self.columns) < 2:
            yield ("staggered",), "needs at least 2 rows and 2 columns"

    @property
    def steps_mm(self) -> tuple[float, float]:
        """Distances of rows and of bolts of a row, 0 of one [mm]."""
        return self.pitch_mm or 0.0, self.gauge_mm or 0.0

    @property
    def positions_mm(self) -> tuple[tuple[float, float], ...]:
        """Axes from the middle of the lap, row by row [mm]."""
        pitch, gauge = self.steps_mm
        places = []
        for row in range(self.rows):
            bolts = self.columns - int(self.staggered and row % 2 == 1)
            x = self.offset_mm[0] + pitch * (row - (self.rows - 1) / 2)
            for column in range(bolts):
                places.append((x, self.offset_mm[1] + gauge * (column - (bolts - 1) / 2)))
        return tuple(places)

    @property
    def nearest_mm(self) -> tuple[tuple[KeyPath, float], ...]:
        """Larger distance, along x or y, of neighbours, and the key that it follows from [mm]."""
        pitch, gauge = self.steps_mm
        distances: list[tuple[KeyPath, float]] = []
        if self.columns > 1:
            distances.append((("pattern", "gauge_mm"), gauge))
        if self.rows > 1:
            nearest = max(pitch, gauge / 2) if self.staggered else pitch
            distances.append((("pattern", "pitch_mm"), nearest))
        if self.staggered and self.rows > 2:
            distances.append((("pattern", "pitch_mm"), 2 * pitch))
        return tuple(distances)


class Plates(BoltedBodies):
    """Two plates with a pattern of bolts through their lap, a single-lap shear joint.

    The lower plate is held at x = 0 or free; x runs along the plates, y across the width from its
    middle, and z upwards from the plane of contact.
    """

    type: Literal["plates"]
    """Kind of structure."""
    plates: PlateDimensions
    pattern: Pattern

    @property
    def length_mm(self) -> float:
        """Length of the whole assembly."""
        return sum(self.plates.free_length_mm) + self.plates.lap_mm

    @property
    def lap_mm(self) -> tuple[float, float]:
        """Where the lap begins and ends along x [mm]."""
        begin = self.plates.free_length_mm[0]
        return begin, begin + self.plates.lap_mm

    @property
    def extent_mm(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest x, y and z of both plates [mm]."""
        half, (lower, upper) = self.plates.width_mm / 2, self.plates.thickness_mm
        return (0.0, self.length_mm), (-half, half), (-lower, upper)

    @property
    def bolt_positions_mm(self) -> tuple[tuple[float, float], ...]:
        """Axes of the bolts, x from the held end and y [mm], row by row."""
        middle = sum(self.lap_mm) / 2
        return tuple((middle + x, y) for x, y in self.pattern.positions_mm)

    @property
    def edge_distances_mm(self) -> tuple[float, float]:
        """Smallest distances of axes from the ends of the lap and from the sides [mm]."""
        x, y = zip(*self.pattern.positions_mm, strict=True)
        return (
            self.plates.lap_mm / 2 - max(map(abs, x)),
            self.plates.width_mm / 2 - max(map(abs, y)),
        )

    @property
    def widest_cell_mm(self) -> float:
        """Side of the largest cells for which there is room [mm]."""
        between = (distance for _, distance in self.pattern.nearest_mm)
        return min(*(2 * distance for distance in self.edge_distances_mm), *between)

    @property
    def grid_mm(self) -> Grid:
        """Lines and cells of the lap [mm]."""
        half, width = self.cell_mm / 2, self.plates.width_mm
        # a centred pattern has nodes on the plane of symmetry
        middle = () if self.pattern.offset_mm[1] else (0.0,)
        cells = tuple(
            Cell((x - half, x + half), (y - half, y + half)) for x, y in self.bolt_positions_mm
        )
        return Grid(
            self._lines(self.lap_mm, [cell.first for cell in cells]),
            self._lines((-width / 2, *middle, width / 2), [cell.second for cell in cells]),
            cells,
        )

    @property
    def lines_beside(self) -> tuple[int, int]:
        """Elements along the plates before and behind the lap."""
        (begin, end), length = self.lap_mm, self.length_mm
        return self._lines((0.0, begin), []).elements, self._lines((end, length), []).elements

    @property
    def size_beside(self) -> tuple[int, int]:
        """Nodes and elements of the plates outside the lap."""
        across = self.grid_mm.second.elements
        counts = list(zip(self.lines_beside, self.mesh.layers, strict=True))
        nodes = sum(along * (across + 1) * (layers + 1) for along, layers in counts)
        return nodes, sum(along * across * layers for along, layers in counts)

    def conflicts(self) -> Problems:
        seat = self.bolts.seat_diameter_mm
        of_edges = (
            (("pattern", "pitch_mm"), ("plates", "lap_mm"), "the ends of the lap"),
            (("pattern", "gauge_mm"), ("plates", "width_mm"), "the sides of the plates"),
        )
        problems = [
            problem
            for (of_pattern, of_plates, where), distance, step in zip(
                of_edges, self.edge_distances_mm, self.pattern.steps_mm, strict=True
            )
            for problem in too_near(
                of_pattern if step else of_plates,
                f"from bolts to {where}",
                distance,
                LEAST_CELL / 2,
                seat,
            )
        ]
        for key, distance in self.pattern.nearest_mm:
            problems += too_near(key, "between bolts", distance, LEAST_CELL, seat)
        yield from problems
        if not problems:
            yield from super().conflicts()
        yield from self.conflicts_of_symmetry()
