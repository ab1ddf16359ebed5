"""Mesh of two tubes with flanges: sectors around the bolts, coincident nodes where flanges meet.

Circles are polygons of the same area.
"""

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
from boltjoint.structure.extrusion.plan import Plan, closed, quads_of

if TYPE_CHECKING:
    from boltjoint.config.flange import Flange

Array = NDArray[np.float64]

_MM = 1e-3


def mesh_of(described: "Flange") -> BoltedMesh:
    """The mesh of two tubes with flanges and their bolts.

    Parameters
    ----------
    described
        Dimensions and divisions.
    """
    grid = described.grid_mm
    angle = places_of(grid.second)[:-1]
    step = np.diff(angle, append=angle[0] + 2 * np.pi)
    metre = _MM * np.sqrt(2 * np.pi / np.sin(step).sum())

    def place(radius: Array, angle: Array) -> Array:
        return metre * radius[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    axes = _MM * np.array(described.bolt_positions_mm)
    flange = grid_plan(grid, axes, radii_of(described.bolts), rings_of(described), place)
    wall, *along = described.lines_of_tubes
    on_wall = flange.label[: wall + 1, : len(angle)]
    ring = np.arange(on_wall.size).reshape(on_wall.shape)
    tube = Plan(flange.plan.point[on_wall.ravel()], quads_of(closed(ring)))

    levels = levels_of(described.flange.thickness_mm, described.mesh.layers)
    below, beyond = (_MM * length for length in described.tubes.length_mm)
    z_below = levels[0][0] + np.linspace(-below, 0.0, along[0] + 1)
    z_beyond = levels[1][-1] + np.linspace(0.0, beyond, along[1] + 1)

    blocks = Blocks()
    lower = blocks.add(LOWER, flange.plan, levels[0])
    upper = blocks.add(UPPER, flange.plan, levels[1])
    lower_tube = blocks.add(LOWER, tube, z_below)
    upper_tube = blocks.add(UPPER, tube, z_beyond)
    blocks.join(lower[0, on_wall], lower_tube[-1])
    blocks.join(upper[-1, on_wall], upper_tube[0])
    sections = add_bolts(blocks, described, flange.bolts, levels, (lower[0], upper[-1]))
    return joined_mesh(blocks, flange, (lower[-1], upper[0]), sections, lower_tube[0])
