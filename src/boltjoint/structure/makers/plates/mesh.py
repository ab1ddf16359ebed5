"""Mesh of two plates with a pattern of bolts: coincident nodes in the lap, bricks all over."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.extrusion.blocks import Blocks
from boltjoint.structure.extrusion.bodies import (
    LOWER,
    UPPER,
    BoltedMesh,
    add_bolts,
    joined_mesh,
    levels_of,
    rings_of,
)
from boltjoint.structure.extrusion.bolt_mesh import radii_of
from boltjoint.structure.extrusion.grid_plan import grid_plan, places_of
from boltjoint.structure.extrusion.plan import rectangle_plan

if TYPE_CHECKING:
    from boltjoint.config.plates import Plates

Array = NDArray[np.float64]

_MM = 1e-3


def mesh_of(described: "Plates") -> BoltedMesh:
    """The mesh of two plates and their bolts.

    Parameters
    ----------
    described
        Dimensions and divisions.
    """
    grid = described.grid_mm
    axes = _MM * np.array(described.bolt_positions_mm)
    lap = grid_plan(grid, axes, radii_of(described.bolts), rings_of(described), _in_metres)
    y = _MM * places_of(grid.second)
    levels = levels_of(described.plates.thickness_mm, described.mesh.layers)
    before, behind = described.lines_beside
    begin, end = (_MM * place for place in described.lap_mm)
    x_before = np.linspace(0.0, begin, before + 1)
    x_behind = np.linspace(end, _MM * described.length_mm, behind + 1)

    blocks = Blocks()
    lower = blocks.add(LOWER, lap.plan, levels[0])
    upper = blocks.add(UPPER, lap.plan, levels[1])
    # the end of a plate in the lap is free
    free_lower = blocks.add(LOWER, rectangle_plan(x_before, y), levels[0])
    free_upper = blocks.add(UPPER, rectangle_plan(x_behind, y), levels[1])
    blocks.join(lower[:, lap.label[0]], free_lower[:, -len(y) :])
    blocks.join(upper[:, lap.label[-1]], free_upper[:, : len(y)])
    sections = add_bolts(blocks, described, lap.bolts, levels, (lower[0], upper[-1]))
    held = free_lower[:, : len(y)]
    return joined_mesh(blocks, lap, (lower[-1], upper[0]), sections, held)


def _in_metres(x: Array, y: Array) -> Array:
    return _MM * np.stack([x, y], axis=-1)
