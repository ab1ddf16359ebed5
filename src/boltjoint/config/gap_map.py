"""Gap between the surfaces of the bars before tightening: its shape, or a map from a CSV file.

Points on all crossings of lines along and across the bar are interpolated bilinearly, others
linearly in their Delaunay triangles. Beyond the points there is no value.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Discriminator, Tag

from boltjoint.config.csv_table import CsvTable, TableError, read_file
from boltjoint.config.entries import Entry
from boltjoint.config.types import DataFile, Number, Positive, Problems

if TYPE_CHECKING:
    from collections.abc import Callable

Array = NDArray[np.float64]

_COLUMNS = ("x_mm", "y_mm", "gap_um")

#: points whose triangles are found in a few seconds
_MOST_POINTS = 250_000
#: kilometres along and across, and a metre of gap
_LARGEST = 1e6

#: difference of a map on both sides of the middle, over its range, beyond which it is refused; the
#: mean of both sides counts, which differs from each by half as much
SYMMETRY_TOLERANCE = 1e-3


@dataclass(frozen=True)
class GapMap:
    """Gap of two surfaces at points of the lap, up to a constant.

    ``x_mm``, ``y_mm`` (points,) from the centre of the lap [mm], ``gap_um`` (points,) [um].
    """

    x_mm: Array
    y_mm: Array
    gap_um: Array

    def at(self, x_mm: Array, y_mm: Array) -> Array:
        """The gap at points [um]; not a number beyond those of the map."""
        return self._interpolant(np.column_stack([x_mm, y_mm]))

    def conflicts(self, lap_mm: float, width_mm: float) -> Iterator[str]:
        """What does not suit a lap of this length and width, as a sentence without a subject.

        Both sides are compared at the corners of the lap and the points of the map in it.
        """
        corner = np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]]) * [lap_mm / 2, width_mm / 2]
        # to a femtometre: a corner may lie on the edge of the map
        corner = np.round(corner, 12)
        missing = np.isnan(self.at(*corner.T))
        if missing.any():
            x, y = corner[np.argmax(missing)]
            yield (
                f"has no value at x = {x:g}, y = {y:g} mm: must cover the lap, from "
                f"{-lap_mm / 2:g} to {lap_mm / 2:g} mm along and from {-width_mm / 2:g} to "
                f"{width_mm / 2:g} mm across, seen from its centre"
            )
            return
        within = (abs(self.x_mm) <= lap_mm / 2) & (abs(self.y_mm) <= width_mm / 2)
        x, y = np.concatenate([corner, np.column_stack([self.x_mm, self.y_mm])[within]]).T
        gap = self.at(x, y)
        difference = abs(gap - self.at(x, -y))
        worst = np.argmax(difference)
        # a femtometre is rounding of a map without range
        if not difference[worst] <= max(SYMMETRY_TOLERANCE * np.ptp(gap), 1e-9):
            yield (
                f"differs by {difference[worst]:.3g} um on both sides of the middle at "
                f"x = {x[worst]:g}, y = {abs(y[worst]):g} mm: must be symmetric about the "
                "middle, as the preload is"
            )

    @cached_property
    def _interpolant(self) -> "Callable[[Array], Array]":
        # imported here, since every job reads this module
        from scipy.interpolate import LinearNDInterpolator, RegularGridInterpolator

        along, across = np.unique(self.x_mm), np.unique(self.y_mm)
        if along.size * across.size == self.gap_um.size and min(along.size, across.size) > 1:
            order = np.lexsort([self.y_mm, self.x_mm])
            values = self.gap_um[order].reshape(along.size, across.size)
            return RegularGridInterpolator((along, across), values, bounds_error=False)
        return LinearNDInterpolator(
            np.column_stack([self.x_mm, self.y_mm]), self.gap_um, rescale=True
        )


def read_gap_map(text: str, file: str) -> GapMap:
    """The map in the text of a CSV file.

    Parameters
    ----------
    text, file
        What the file holds, and its name.

    Raises
    ------
    TableError
        If there are other columns, a cell is no number, a point stands twice, or all points lie on
        one line.
    """
    table = CsvTable(text, file)
    if sorted(table.keys) != sorted(_COLUMNS):
        raise TableError(f"{file}: must have the columns {', '.join(_COLUMNS)}")
    columns = table.columns()
    point = np.column_stack([columns["x_mm"], columns["y_mm"]])
    if len(point) > _MOST_POINTS:
        raise TableError(f"{file}: must have at most {_MOST_POINTS} points")
    _, first = np.unique(point, axis=0, return_index=True)
    if again := sorted(set(range(len(point))) - set(first.tolist())):
        x, y = point[again[0]]
        raise TableError(f"{file}:{again[0] + 2}: the point {x:g}, {y:g} mm must not appear twice")
    for key in _COLUMNS:
        if len(point) and (largest := abs(columns[key]).max()) > _LARGEST:
            raise TableError(f"{file}: {key}: {largest:g} must be at most {_LARGEST:g}")
    if _lie_on_a_line(point):
        raise TableError(f"{file}: must have points that do not all lie on one line")
    return GapMap(*(columns[key] for key in _COLUMNS))


def _lie_on_a_line(point: Array) -> bool:
    """Whether points leave no room for triangles, up to a millionth of their extent."""
    if len(point) < 3 or (extent := np.ptp(point, axis=0)).min() < 1e-6:
        return True
    along, across = np.linalg.svd((point - point.mean(axis=0)) / extent, compute_uv=False)
    return across < 1e-6 * along


def load_gap_map(path: str | Path) -> GapMap:
    """The map in a CSV file, as ``read_gap_map``."""
    return read_gap_map(read_file(path), str(path))


#: fewest elements along a wave
ELEMENTS_IN_WAVE = 4


class GapShape(Entry):
    """Form error of both surfaces together, as flatness and waviness.

    The waviness is a cosine along the bar. The surfaces touch where both together are nearest.
    """

    flatness_um: Number = 0.0
    """Distance of two parallel planes that hold the surface, a paraboloid around the centre of the
    lap whose corners lie in one of them: positive where it is hollow, so that the corners touch
    first, negative where it is crowned, so that the centre does."""
    waviness_um: Number = 0.0
    """Amplitude of the waviness, half of the height from valley to crest: positive with a valley at
    the centre of the lap, negative with a crest."""
    wavelength_mm: Positive | None = None
    """Wavelength of the waviness along the bar, at least four elements of the lap; needed with
    ``waviness_um``."""

    def conflicts(self) -> Problems:
        keys = self.model_fields_set
        if not keys & {"flatness_um", "waviness_um"}:
            yield ("flatness_um",), "is missing: or give waviness_um and wavelength_mm"
        elif "waviness_um" in keys and self.wavelength_mm is None and self.waviness_um:
            yield ("wavelength_mm",), "is missing: length of a wave along the bar"
        elif self.wavelength_mm is not None and "waviness_um" not in keys:
            yield ("waviness_um",), "is missing: amplitude of the wave"


def _form(value: object) -> str | None:
    if isinstance(value, str):
        return "file"
    return "shape" if isinstance(value, Mapping | GapShape) else None


Gap = Annotated[
    Annotated[DataFile, Tag("file")] | Annotated[GapShape, Tag("shape")],
    Discriminator(
        _form,
        custom_error_type="no_values",
        custom_error_message="must be the name of a CSV file, or have flatness_um, or waviness_um "
        "with wavelength_mm",
    ),
]
