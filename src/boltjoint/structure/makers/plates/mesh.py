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
    radii_of,
    rings_of,
)
from boltjoint.structure.extrusion.grid_plan import grid_plan, places_of
from boltjoint.structure.extrusion.plan import rectangle_plan, tributary_area

if TYPE_CHECKING:
    from boltjoint.config.plates import Plates

Array = NDArray[np.float64]

_MM = 1e-3


def mesh_of(described: "Plates") -> BoltedMesh:
    """The mesh of two plates and their bolts.

    Pairs are ordered by x, then y.

    Parameters
    ----------
    described
        Dimensions and divisions.
    """
    grid = described.grid_mm
    lap = grid_plan(grid, radii_of(described.bolts), rings_of(described), _in_metres)
    y = _MM * places_of(grid.second)
    (low, high), (under, above) = described.plates.thickness_mm, described.mesh.layers
    levels = np.linspace(-_MM * low, 0.0, under + 1), np.linspace(0.0, _MM * high, above + 1)
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
    coordinate, hexahedron, part, label = blocks.joined()

    pair = label[np.stack([lower[-1], upper[0]], axis=-1)]
    # to a picometre: nodes on one line have the same x but for rounding
    along, across, _ = np.round(coordinate[pair[:, 0]], 12).T
    order = np.lexsort([across, along])
    return BoltedMesh(
        coordinate=coordinate,
        hexahedron=hexahedron,
        part=part,
        pair=pair[order],
        area=tributary_area(lap.plan)[order],
        section=label[np.concatenate(sections)],
        bolt_of_pair=np.repeat(np.arange(len(sections)), [len(section) for section in sections]),
        bolt_position=np.array([[*bolt.axis, 0.0] for bolt in lap.bolts]),
        held=np.unique(label[free_lower[:, : len(y)]]),
    )


def _in_metres(x: Array, y: Array) -> Array:
    return _MM * np.stack([x, y], axis=-1)
