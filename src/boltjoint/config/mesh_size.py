"""Size of the mesh of an assembly, by counting its divisions: nothing is built."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

#: more than any machine can count: sizes beyond it would overflow
COUNTLESS = 1e30


class MeshSize(NamedTuple):
    """Nodes, elements and contact pairs of the mesh of an assembly."""

    nodes: int
    elements: int
    pairs: int


class Divisions(Protocol):
    """What of a half lap its size follows from: an ``Assembly`` has it."""

    bar: Any
    bolts: Any
    mesh: Any
    bolt_count: int
    bolt_positions_mm: Sequence[float]
    elements_outside_lap: Sequence[float]
    layers_in_washer: float
    rings_head_to_washer_edge: int


def mesh_size(assembly: Divisions) -> MeshSize:
    """Size of the mesh of an assembly, by counting its divisions."""
    mesh = assembly.mesh
    across, along, layers = (
        mesh.ring_cells_across_width,
        mesh.ring_cells_along_bar,
        mesh.layers_per_half_height,
    )
    bolts = assembly.bolt_count
    around = 2 * (across + along)
    rings_of_pairs, columns_of_pairs = _rings_and_columns_of_pairs(assembly)
    pairs = around * rings_of_pairs + (across + 1) * columns_of_pairs
    free = sum(int(min(count, COUNTLESS)) for count in assembly.elements_outside_lap)
    columns = (bolts - 1) * mesh.columns_between_bolt_cells + 2 * mesh.columns_at_each_lap_end
    rings = mesh.rings_under_head + mesh.rings_head_to_cell_edge

    shank_points = (across + 1) * (along + 1) + mesh.rings_in_shank * around
    # a ring more where the hole of the washers is narrower than that of the bars
    over_hole = int(assembly.bolts.has_narrow_washers)
    head_points = shank_points + (mesh.rings_under_head + 1 + over_hole) * around
    shank_quads = across * along + mesh.rings_in_shank * around
    head_quads = shank_quads + (mesh.rings_under_head + 1 + over_hole) * around
    in_heads = 2 * mesh.layers_in_head
    washer_quads = (mesh.rings_under_head + assembly.rings_head_to_washer_edge + over_hole) * around
    washers = 0 if assembly.bolts.washer is None else len(assembly.bolts.washer.under)
    in_washers = washers * int(min(assembly.layers_in_washer, COUNTLESS))

    # nodes are shared where a free bar meets its half of the lap, a head its shank and its bar, and
    # a washer both; of a ring over the hole one side is tied to nothing
    free_nodes = (free + 2) * (across + 1) * (2 * layers + 1) - 2 * (across + 1) * (layers + 1)
    shank_nodes = shank_points * (2 * (layers + 1) + in_washers)
    head_nodes = in_heads * head_points + 2 * over_hole * around
    washer_nodes = in_washers * (washer_quads + around)
    of_bolt = shank_nodes + head_nodes + washer_nodes
    return MeshSize(
        nodes=2 * pairs * (layers + 1) + free_nodes + bolts * of_bolt,
        elements=2 * layers * (bolts * around * rings + columns * across)
        + 2 * layers * across * free
        + bolts * ((2 * layers + in_washers) * shank_quads + in_heads * head_quads)
        + bolts * in_washers * washer_quads,
        pairs=pairs,
    )


def pairs_of_one_side(assembly: Divisions) -> int:
    """Coincident node pairs on the centre line and on one side of it."""
    rings, columns = _rings_and_columns_of_pairs(assembly)
    return (mesh_size(assembly).pairs + 2 * rings + columns) // 2


def longest_element_of_lap_mm(assembly: Divisions) -> float:
    """Longest element of the contact along the bar: of the columns and rings of the mesh."""
    mesh, bolts, positions = assembly.mesh, assembly.bolts, assembly.bolt_positions_mm
    cell, seat = mesh.bolt_cell_length_mm, bolts.seat_diameter_mm
    in_washer = assembly.rings_head_to_washer_edge
    # contradictions, as of a washer with no ring beyond it, are reported on their own
    beyond = max(1, mesh.rings_head_to_cell_edge - in_washer)
    pitches = (right - left for left, right in pairwise(positions))
    return max(
        cell / mesh.ring_cells_along_bar,
        (bolts.head_diameter_mm - bolts.hole_diameter_mm) / 2 / mesh.rings_under_head,
        (seat - bolts.head_diameter_mm) / 2 / max(1, in_washer),
        (cell - seat) / 2 / beyond,
        (positions[0] - cell / 2) / mesh.columns_at_each_lap_end,
        (assembly.bar.lap_mm - positions[-1] - cell / 2) / mesh.columns_at_each_lap_end,
        *((pitch - cell) / mesh.columns_between_bolt_cells for pitch in pitches),
    )


def _rings_and_columns_of_pairs(assembly: Divisions) -> tuple[int, int]:
    """Rings of contact pairs around all holes, and columns across the bar that are in no ring."""
    mesh, bolts = assembly.mesh, assembly.bolt_count
    rings = mesh.rings_under_head + mesh.rings_head_to_cell_edge + 1
    between = (bolts - 1) * (mesh.columns_between_bolt_cells - 1)
    return bolts * rings, between + 2 * mesh.columns_at_each_lap_end
