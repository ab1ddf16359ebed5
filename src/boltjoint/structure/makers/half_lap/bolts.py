"""Bolts and washers of a half-lap assembly as hexahedra, tied to the bars.

A washer is tied to the bar below it from the edge of the hole to its own edge, and to the head or
nut above it from its own hole to the edge of the head.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.half_lap.blocks import Blocks
from boltjoint.structure.makers.half_lap.cell import BoltRadii, CellDivisions
from boltjoint.structure.makers.half_lap.plan import BoltPlan, Labels, bolt_plan

if TYPE_CHECKING:
    from boltjoint.config.assembly import Assembly

Array = NDArray[np.float64]

_MM = 1e-3


def radii_of(assembly: "Assembly") -> BoltRadii:
    """Radii of a bolt and its washers [m]."""
    bolts = assembly.bolts
    washer, hole = bolts.washer, bolts.narrow_hole_mm
    return BoltRadii(
        shank=_MM * bolts.shank_diameter_mm / 2,
        hole=_MM * bolts.hole_diameter_mm / 2,
        head=_MM * bolts.head_diameter_mm / 2,
        washer_hole=None if hole is None else _MM * hole / 2,
        washer=None
        if washer is None or not bolts.has_wide_washers
        else _MM * washer.diameter_mm / 2,
    )


def divisions_of(assembly: "Assembly") -> CellDivisions:
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


def levels_of(assembly: "Assembly") -> tuple[Array, Array]:
    """Levels along z of the lower and of the upper half of the height [m]."""
    half, layers = _MM * assembly.bar.height_mm / 2, assembly.mesh.layers_per_half_height
    return np.linspace(-half, 0.0, layers + 1), np.linspace(0.0, half, layers + 1)


def add_bolt(
    blocks: Blocks,
    assembly: "Assembly",
    on_bars: tuple[Labels, Labels],
    axis: float,
    parts: tuple[int, int],
) -> Labels:
    """Add a bolt with its washers, and return the labels of its pretension section.

    Parameters
    ----------
    blocks
        What the bars were added to.
    assembly
        Dimensions and mesh divisions.
    on_bars
        Nodes under the nut, below bar A, and under the head, on top of bar B: from the edge of the
        hole to that of head or washer, shape (rings + 1, around).
    axis
        x of the bolt's axis [m].
    parts
        Numbers of the parts of the bolt, and of its washers.

    Returns
    -------
    ndarray
        Nodes on the nut's and on the head's side, shape (pairs, 2).
    """
    bolts, layers = assembly.bolts, assembly.mesh.layers_in_head
    plan = bolt_plan(radii_of(assembly), divisions_of(assembly)).moved(axis)
    under_nut, under_head = (_washer_levels(assembly, end) for end in ("nut", "head"))
    lower, upper = levels_of(assembly)
    washer_below, washer_above = lower[0] - under_nut[::-1], upper[-1] + under_head
    shank_a = blocks.add(parts[0], plan.shank, np.concatenate([washer_below[:-1], lower]))
    shank_b = blocks.add(parts[0], plan.shank, np.concatenate([upper, washer_above[1:]]))
    bottom, top = washer_below[0], washer_above[-1]
    nut_levels = np.linspace(bottom - _MM * bolts.nut_height_mm, bottom, layers + 1)
    head_levels = np.linspace(top, top + _MM * bolts.head_height_mm, layers + 1)
    nut = blocks.add(parts[0], plan.head, nut_levels)
    head = blocks.add(parts[0], plan.head, head_levels)

    in_shank = len(plan.shank.point)
    blocks.join(shank_a[0], nut[-1, :in_shank])
    blocks.join(shank_b[-1], head[0, :in_shank])
    _tie(blocks, plan, on_bars[0], nut[-1], parts[1], washer_below, bar_first=False)
    _tie(blocks, plan, on_bars[1], head[0], parts[1], washer_above, bar_first=True)
    return np.stack([shank_a[-1], shank_b[0]], axis=-1)


def _washer_levels(assembly: "Assembly", end: str) -> Array:
    """Levels of the washer under head or nut, from the bar on [m]; 0 alone where there is none."""
    washer = assembly.bolts.washer
    if washer is None or end not in washer.under:
        return np.zeros(1)
    return np.linspace(0.0, _MM * washer.thickness_mm, int(assembly.layers_in_washer) + 1)


def _tie(
    blocks: Blocks,
    plan: BoltPlan,
    on_bar: Labels,
    of_head: Labels,
    part: int,
    levels: Array,
    *,
    bar_first: bool,
) -> None:
    """Tie head or nut to its bar, through a washer where there are levels of one."""
    under_head = of_head[plan.under_head]
    if len(levels) == 1:
        over_bar = under_head[plan.over_hole :]
        blocks.join(on_bar[: len(over_bar)], over_bar)
        return
    washer = blocks.add(part, plan.washer, levels)[:, plan.rings_of_washer]
    to_bar, to_head = (washer[0], washer[-1]) if bar_first else (washer[-1], washer[0])
    blocks.join(on_bar, to_bar[plan.over_hole :])
    blocks.join(to_head[: len(under_head)], under_head)
