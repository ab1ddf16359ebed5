"""Divisions and levels of the bolts and washers of a half-lap assembly."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.extrusion.bolts import BoltLevels, washer_levels
from boltjoint.structure.extrusion.cell import CellDivisions

if TYPE_CHECKING:
    from boltjoint.config.lap_joint import LapJoint

Array = NDArray[np.float64]

_MM = 1e-3


def divisions_of(assembly: "LapJoint") -> CellDivisions:
    """Divisions of the cell of a bolt."""
    mesh = assembly.mesh
    return CellDivisions(
        across=mesh.ring_cells_across_width,
        along=mesh.ring_cells_along_bar,
        rings_in_shank=mesh.rings_in_shank,
        rings_under_head=mesh.rings_under_head,
        rings_head_to_edge=mesh.rings_head_to_cell_edge,
        rings_head_to_washer=assembly.rings_head_to_washer_edge,
    )


def levels_of(assembly: "LapJoint") -> tuple[Array, Array]:
    """Levels along z of the lower and of the upper half of the height [m]."""
    half, layers = _MM * assembly.bar.height_mm / 2, assembly.mesh.layers_per_half_height
    return np.linspace(-half, 0.0, layers + 1), np.linspace(0.0, half, layers + 1)


def bolt_levels(assembly: "LapJoint") -> BoltLevels:
    """Levels of nodes along the axis of a bolt [m]."""
    bolts, layers = assembly.bolts, int(assembly.layers_in_washer)
    return BoltLevels.of_stack(
        levels_of(assembly),
        (washer_levels(bolts, "nut", layers), washer_levels(bolts, "head", layers)),
        (_MM * bolts.nut_height_mm, _MM * bolts.head_height_mm),
        assembly.mesh.layers_in_head,
    )
