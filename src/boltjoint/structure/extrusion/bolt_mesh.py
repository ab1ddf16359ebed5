"""Bolts and washers as hexahedra, tied to the two plates that they go through.

A washer is tied to the plate below it from the edge of the hole to its own edge, and to the head or
nut above it from its own hole to the edge of the head. In the middle of a shank, the pretension
section, the nodes are double.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.extrusion.blocks import Blocks
from boltjoint.structure.extrusion.bolt_plan import BoltPlan
from boltjoint.structure.extrusion.cell import BoltRadii
from boltjoint.structure.extrusion.plan import Labels

if TYPE_CHECKING:
    from boltjoint.config.bolts import BoltDimensions

Array = NDArray[np.float64]

_MM = 1e-3


@dataclass(frozen=True, eq=False)
class BoltLevels:
    """Levels of nodes along the axis of a bolt [m], each ascending.

    Attributes
    ----------
    lower, upper
        Of both plates, which meet at the pretension section.
    washer_below, washer_above
        Of the washers under nut and head, with the face of the plate alone where there is none.
    nut, head
        Of nut and head.
    """

    lower: Array
    upper: Array
    washer_below: Array
    washer_above: Array
    nut: Array
    head: Array

    @classmethod
    def of_stack(
        cls,
        plates: tuple[Array, Array],
        washers: tuple[Array, Array],
        heights: tuple[float, float],
        layers: int,
    ) -> "BoltLevels":
        """Levels of a bolt through two plates.

        Parameters
        ----------
        plates
            Levels of the lower and of the upper one.
        washers
            Levels of the washers under nut and head, from the plate on: 0 alone where there is
            none.
        heights
            Of nut and head.
        layers
            Elements through the height of either.
        """
        lower, upper = plates
        under_nut, under_head = washers
        below, above = lower[0] - under_nut[::-1], upper[-1] + under_head
        nut, head = heights
        return cls(
            lower,
            upper,
            below,
            above,
            np.linspace(below[0] - nut, below[0], layers + 1),
            np.linspace(above[-1], above[-1] + head, layers + 1),
        )


def radii_of(bolts: "BoltDimensions") -> BoltRadii:
    """Radii of a bolt and its washers [m]."""
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


def washer_levels(bolts: "BoltDimensions", end: str, layers: int) -> Array:
    """Levels of the washer under head or nut, from its body on [m]; 0 alone where there is none."""
    washer = bolts.washer
    if washer is None or end not in washer.under:
        return np.zeros(1)
    return np.linspace(0.0, _MM * washer.thickness_mm, layers + 1)


def add_bolt(
    blocks: Blocks,
    plan: BoltPlan,
    levels: BoltLevels,
    on_plates: tuple[Labels, Labels],
    parts: tuple[int, int],
) -> Labels:
    """Add a bolt with its washers, and return the labels of its pretension section.

    Parameters
    ----------
    blocks
        What the plates were added to.
    plan, levels
        The bolt seen from above, and along its axis.
    on_plates
        Nodes under the nut and under the head: from the edge of the hole to that of head or washer,
        shape (rings + 1, around).
    parts
        Numbers of the parts of the bolt, and of its washers.

    Returns
    -------
    ndarray
        Nodes on the nut's and on the head's side, shape (pairs, 2).
    """
    below, above = levels.washer_below, levels.washer_above
    shank_a = blocks.add(parts[0], plan.shank, np.concatenate([below[:-1], levels.lower]))
    shank_b = blocks.add(parts[0], plan.shank, np.concatenate([levels.upper, above[1:]]))
    nut = blocks.add(parts[0], plan.head, levels.nut)
    head = blocks.add(parts[0], plan.head, levels.head)

    in_shank = len(plan.shank.point)
    blocks.join(shank_a[0], nut[-1, :in_shank])
    blocks.join(shank_b[-1], head[0, :in_shank])
    _tie(blocks, plan, on_plates[0], nut[-1], parts[1], below, plate_first=False)
    _tie(blocks, plan, on_plates[1], head[0], parts[1], above, plate_first=True)
    return np.stack([shank_a[-1], shank_b[0]], axis=-1)


def _tie(
    blocks: Blocks,
    plan: BoltPlan,
    on_plate: Labels,
    of_head: Labels,
    part: int,
    levels: Array,
    *,
    plate_first: bool,
) -> None:
    """Tie head or nut to its plate, through a washer where there are levels of one."""
    under_head = of_head[plan.under_head]
    if len(levels) == 1:
        over_plate = under_head[plan.over_hole :]
        blocks.join(on_plate[: len(over_plate)], over_plate)
        return
    washer = blocks.add(part, plan.washer, levels)[:, plan.rings_of_washer]
    to_plate, to_head = (washer[0], washer[-1]) if plate_first else (washer[-1], washer[0])
    blocks.join(on_plate, to_plate[plan.over_hole :])
    blocks.join(to_head[: len(under_head)], under_head)
